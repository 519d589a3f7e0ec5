"""Where the peers live: a virtual environment beside this file, made when first needed, and what is compiled for it."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
VENV = HERE / ".venv"

PEERS = ["heyoka", "numpy", "scipy"]


def processor():
    """What all of it runs on."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    values = dict(line.split(":", 1) for line in lines if ":" in line)
    values = {name.strip(): value.strip() for name, value in values.items()}
    wide = "AVX-512" if "avx512f" in values.get("flags", "").split() else "without AVX-512"
    return f"{values.get('model name', 'unknown processor')}, {wide}"


def enter_environment():
    """Runs the calling script again inside the environment."""
    python = VENV / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", *PEERS], check=True)
    if Path(sys.prefix) != VENV:
        os.execv(python, [str(python), *sys.argv])


@cache
def dop853():
    """The program of dop853.cpp, compiled for this processor; its coefficients are those of SciPy."""
    import numpy
    from scipy.integrate._ivp import dop853_coefficients as scipy

    built = VENV / "dop853"
    built.mkdir(exist_ok=True)
    stages = scipy.N_STAGES
    lines = []
    for name, values in (
        ("A", scipy.A),
        ("B", scipy.B),
        ("E5", scipy.E5[:stages]),
        ("E3", scipy.E3[:stages]),
        ("D", scipy.D),
    ):
        shape = "".join(f"[{count}]" for count in values.shape)
        numbers = ", ".join(repr(float(value)) for value in numpy.ravel(values))
        lines.append(f"constexpr double {name}{shape} = {{{numbers}}};\n")
    (built / "tableau.h").write_text("".join(lines))
    program = built / "dop853"
    flags = ["-O3", "-march=native", "-std=c++17", f"-I{built}"]
    subprocess.run(["c++", *flags, "-o", program, HERE / "dop853.cpp"], check=True)
    return program
