"""What `import chatter` brings, and what it does not."""

import subprocess
import sys

import chatter as ch


def test_every_name_is_there_and_nothing_is_imported_before_it_is_asked_for():
    assert dir(ch) == sorted(ch.__all__)
    for name in ch.__all__:
        assert getattr(ch, name) is not None, name
    heavy = {"pandas", "matplotlib", "xarray", "tqdm", "sympy"}
    use = "chatter.Model.shipped('bouncing_ball').simulate(1)"
    for used, unwanted in [("pass", heavy | {"numpy"}), (use, heavy)]:
        script = f"import sys, chatter; {used}; print(*({unwanted!r} & set(sys.modules)))"
        said = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
        assert said.stdout.strip() == "", used
