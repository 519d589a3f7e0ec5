"""Where the peers live: a virtual environment beside this file, made when first needed."""

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
VENV = HERE / ".venv"

PEERS = ["heyoka", "numpy", "scipy"]


def enter_environment():
    """Runs the calling script again inside the environment."""
    python = VENV / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", *PEERS], check=True)
    if Path(sys.prefix) != VENV:
        os.execv(python, [str(python), *sys.argv])
