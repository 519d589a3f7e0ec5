"""What `import chatter` brings, and what it does not."""

import subprocess
import sys

import chatter as ch


def test_every_name_is_there_and_nothing_is_imported_before_it_is_asked_for():
    assert dir(ch) == sorted(ch.__all__)
    for name in ch.__all__:
        assert getattr(ch, name) is not None, name
    lazy = "import sys, chatter; heavy = {'numpy', 'pandas', 'matplotlib', 'xarray', 'tqdm', 'sympy'} & set(sys.modules); sys.exit(repr(heavy) * bool(heavy))"
    subprocess.run([sys.executable, "-c", lazy], check=True)
    used = lazy.replace("chatter;", "chatter; chatter.Model.shipped('bouncing_ball').simulate(1);").replace("'numpy', ", "")
    subprocess.run([sys.executable, "-c", used], check=True)
