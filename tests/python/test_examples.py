"""The examples run as they are, and what documents show of Python is so."""

import os
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples" / "python").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(path, tmp_path):
    done = subprocess.run(
        [sys.executable, str(path)],
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / f"{path.stem}.png").stat().st_size > 10_000


def test_there_are_examples():
    assert len(EXAMPLES) >= 3


def test_names_that_documents_use_are_there():
    import chatter as ch

    run = ch.Model.shipped("pressure_relief_valve").simulate(8)
    things = {"ch": ch, "run": run, "valve": run.model, "d": ch.Diagram, "orbit": ch.PeriodicOrbit, "b": ch.ModelBuilder()}
    missing = []
    for name in ["README.md", "docs/julia.md", "docs/matlab.md", "examples/cluster/README.md"]:
        text = (ROOT / name).read_text()
        # Indented lines are code; those of a shell begin otherwise.
        code = "\n".join(line for line in text.splitlines() if line.startswith("    "))
        for thing, attribute in re.findall(r"(?<![\w.])(ch|run|valve|d|orbit|b)\.(\w+)\(", code):
            if not hasattr(things[thing], attribute):
                missing.append((name, thing, attribute))
    assert not missing
