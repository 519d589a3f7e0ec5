"""Branches from all orbits: the files of the command, broken off and gone on with, in shares."""

import os
import subprocess
import sys

import numpy as np
import pytest

import chatter as ch

ASKED = dict(omega=(2.4, 3.2), step=0.004, all=3, starts=40)
LINE = "continue impact_oscillator --set omega=2.6 --sweep omega=2.4:3.2 --step 0.004 --all 3 --starts 40"


@pytest.fixture(scope="module")
def oscillator():
    return ch.Model.shipped("impact_oscillator").with_values(omega=2.6)


@pytest.fixture(scope="module")
def theirs(tmp_path_factory):
    path = tmp_path_factory.mktemp("command") / "theirs.npz"
    command(LINE, path)
    return path


def command(line, out):
    subprocess.run([sys.executable, "-m", "chatter", *line.split(), "--out", str(out)], check=True, capture_output=True)


def same(found, path):
    """Whether branches are those of a table, to the bit."""
    with np.load(path) as table:
        for name in ("omega", "period", "x", "v"):
            ours = np.concatenate([branch[name] for branch in found])
            assert np.array_equal(ours, table[name]), name
        kinds = [one for branch in found for one in branch._document["special"]]
        assert [one["kind"] for one in kinds] == list(table["special_kind"])
        assert [one["value"] for one in kinds] == list(table["special_omega"])


def test_the_file_is_that_of_the_command_to_the_bit(oscillator, theirs, tmp_path):
    ours = tmp_path / "ours.npz"
    found = oscillator.branches(out=ours, **ASKED)
    assert ours.read_bytes() == theirs.read_bytes()
    assert os.listdir(tmp_path) == ["ours.npz"]
    assert len(found) > 1
    same(found, theirs)
    assert any(branch.special for branch in found)


def test_another_seed_draws_other_starts_and_finds_the_same_branches(oscillator):
    asked = dict(omega=(2.55, 2.65), all=1, starts=60)
    found = [oscillator.branches(seed=seed, **asked) for seed in (0, 5)]
    assert len(found[0]) == len(found[1]) >= 1
    for name in ("x", "v"):
        # At the value where the orbits were found.
        there = [sorted(branch[name][np.argmin(np.abs(branch["omega"] - 2.6))] for branch in one) for one in found]
        np.testing.assert_allclose(*there, atol=1e-9)


def test_what_was_broken_off_goes_on_to_the_same_bits(oscillator, theirs, tmp_path):
    class Enough(Exception):
        pass

    told = []

    def enough(_, message):
        told.append(message)
        if any("omega" in one for one in told):
            raise Enough

    out, journal = tmp_path / "ours.npz", tmp_path / "kept.journal"
    for where in ({"out": out}, {"journal": journal}):
        told.clear()
        with pytest.raises(Enough):
            oscillator.branches(progress=enough, **where, **ASKED)
    assert not out.exists() and sorted(os.listdir(tmp_path)) == ["kept.journal", "ours.npz.journal"]
    with pytest.warns(ch.ChatterWarning, match="going on"):
        same(ch.resume(out), theirs)
    assert out.read_bytes() == theirs.read_bytes() and not (tmp_path / "ours.npz.journal").exists()
    with pytest.raises(ch.InputError, match="finished"):
        ch.resume(out)
    with pytest.warns(ch.ChatterWarning, match="going on"):
        found = ch.resume(journal)
    same(found, theirs)
    # The journal stays, and the model comes back with what was set into it.
    assert journal.exists() and found[0].model.parameters["omega"] == 2.6
    with pytest.raises(ch.InputError, match="unfinished branches with other options"):
        oscillator.branches(journal=journal, **{**ASKED, "step": 0.005})


def test_shares_come_to_the_file_of_one_process(oscillator, theirs, tmp_path):
    out = tmp_path / "parts.npz"
    journals = [oscillator.branches_shard(k, 3, out=out, **ASKED) for k in (2, 1)]
    assert journals[0] == str(tmp_path / "parts.2-of-3.journal")
    # The third is the command's.
    command(LINE + " --shard 3/3", out)
    with pytest.warns(ch.ChatterWarning, match="going on"):
        merged = ch.merge([*journals, tmp_path / "parts.3-of-3.journal"], out)
    assert out.read_bytes() == theirs.read_bytes()
    same(merged, theirs)
    other = oscillator.branches_shard(1, 9, out=tmp_path / "other.npz", **{**ASKED, "omega": (2.5, 2.7)})
    with pytest.raises(ch.InputError, match="another sweep"):
        ch.merge([journals[0], other], tmp_path / "both.npz")


def test_without_a_search_it_is_one_orbit(oscillator):
    (one,) = oscillator.branches(omega=(2.55, 2.65))
    (other,) = ch.branches(oscillator, "omega", 2.55, 2.65)
    assert np.array_equal(one["x"], other["x"]) and one.parameter == "omega"


def test_what_makes_no_sense_is_refused(oscillator, tmp_path):
    for asked, told in [
        (dict(), "over one parameter"),
        (dict(omega=(2, 3), r=(0.5, 0.6)), "over one parameter"),
        (dict(omega=(2, 3, 10)), "expected \\(low, high\\)"),
        (dict(omega=(2, 3), starts=10), "starts: .*there is none"),
        (dict(omega=(2, 3), all=1000), "periods 1000: expected"),
        (dict(omega=(2, 3), out=tmp_path / "a.npz", journal=tmp_path / "b"), "leave out `journal`"),
        (dict(rho=(2, 3)), "no parameter `rho`"),
    ]:
        with pytest.raises(ch.InputError, match=told):
            oscillator.branches(**asked)
    with pytest.raises(ch.InputError, match="from 1 to COUNT"):
        oscillator.branches_shard(4, 3, out=tmp_path / "a.npz", **ASKED)
    with pytest.raises(ch.InputError, match="no option deep"):
        ch.branches(oscillator, "omega", 2, 3, deep=1)
    assert os.listdir(tmp_path) == []
