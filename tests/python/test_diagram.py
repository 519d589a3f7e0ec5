"""Orbit diagrams against the command, themselves, and maps that are known."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import chatter as ch

ASKED = dict(observe="y2", section="closing", start="carry", chunk=8, transient=60, keep=20)


@pytest.fixture(scope="module")
def valve():
    return ch.Model.shipped("pressure_relief_valve")


@pytest.fixture(scope="module")
def diagram(valve):
    return valve.diagram(q=(0.0201, 0.0206, 24), **ASKED)


def command(*arguments):
    subprocess.run([sys.executable, "-m", "chatter", *arguments], check=True, capture_output=True)


OPTIONS = [
    "diagram", "pressure_relief_valve", "--sweep", "q=0.0201:0.0206:24", "--section", "closing", "--observe", "y2",
    "--start", "carry", "--chunk", "8", "--transient", "60", "--keep", "20",
]  # fmt: skip


def test_the_file_is_that_of_the_command_to_the_bit(valve, diagram, tmp_path):
    ours, theirs = tmp_path / "ours.npz", tmp_path / "theirs.npz"
    written = valve.diagram(q=(0.0201, 0.0206, 24), out=ours, **ASKED)
    command(*OPTIONS, "--out", str(theirs))
    assert ours.read_bytes() == theirs.read_bytes()
    assert sorted(os.listdir(tmp_path)) == ["ours.npz", "theirs.npz"]
    with np.load(theirs) as file:
        for name in [*diagram.columns, *diagram.samples]:
            assert np.array_equal(diagram[name], file[name]), name
            assert np.array_equal(written[name], file[name]), name
            assert np.array_equal(ch.resume(theirs)[name], file[name]), name


def test_an_orbit_is_followed_from_where_it_started(valve, diagram):
    periodic = int(np.argmax(diagram["period"] == 1))
    orbit = diagram.orbit(periodic)
    assert orbit.outcome == "periodic" and orbit.samples["y2"].shape == (20,)
    run = orbit.model.simulate(stop="section:closing=80", sample=None)
    np.testing.assert_allclose(run.end["y2"], orbit["y2"][-1], atol=1e-9)
    assert diagram.orbit(-1).parameters["q"] == 0.0206
    with pytest.raises(IndexError):
        diagram.orbit(24)


def test_parts_of_the_samples_are_all_of_them(diagram):
    parts = [diagram.orbit(k)["y2"] for k in range(len(diagram))]
    assert np.array_equal(np.concatenate(parts), diagram["y2"])
    data = diagram.to_xarray()
    assert np.array_equal(data["y2"].values[3], parts[3])
    frame = diagram.to_pandas(samples=True)
    assert np.array_equal(frame["q"], diagram["q"][diagram["column"]])


def test_what_was_broken_off_goes_on_to_the_same_bits(valve, diagram, tmp_path):
    class Enough(Exception):
        pass

    def enough(done, _):
        if done > 0.1:
            raise Enough

    journal = tmp_path / "fig.journal"
    wide = dict(ASKED, transient=100, threads=1)
    with pytest.raises(Enough):
        valve.diagram(q=(0.0201, 0.0206, 160), journal=journal, progress=enough, **wide)
    with pytest.warns(ch.ChatterWarning, match="going on"):
        resumed = ch.resume(journal)
    whole = valve.diagram(q=(0.0201, 0.0206, 160), **wide)
    for name in [*whole.columns, *whole.samples]:
        assert np.array_equal(whole[name], resumed[name]), name
    with pytest.warns(ch.ChatterWarning, match="160 of 160"):
        assert np.array_equal(ch.resume(journal)["y2"], whole["y2"])


def test_a_linear_oscillator_settles_where_its_solution_is():
    text = """
    [parameters]
    omega = 1.3
    zeta = 0.2
    [flight]
    x = "v"
    v = "cos(omega*t) - 2*zeta*v - x"
    [initial]
    x = 0
    v = 0
    """
    d = ch.Model(text).diagram(omega=(0.5, 2, 9), observe={"x": "x", "speed": "v"}, period="2*pi/omega", transient=200, keep=3)
    omega = d["omega"]
    amplitude = 1 / (1 - omega**2 + 0.4j * omega)
    last = np.arange(len(d)) * 3 + 2
    np.testing.assert_allclose(d["x"][last], amplitude.real, atol=1e-10)
    np.testing.assert_allclose(d["speed"][last], (1j * omega * amplitude).real, atol=1e-10)
    assert np.all(d["period"] == 1) and np.all(d["impacts_per_return"] == 0)


def test_maps_and_initial_values_are_swept():
    model = ch.Model.shipped("impact_oscillator_two_sided").with_values(sigma=1, omega=2)
    asked = dict(period="2*pi/omega", observe="v", transient=50, keep=20)
    d = model.diagram(sweep={"initial:x": (-0.9, 0.9, 5), "initial:v": (-2, 2, 4)}, **asked)
    assert d.swept == ("initial_x", "initial_v") and len(d) == 20
    assert d.samples == {}
    assert set(np.unique(d["initial_v"])) == set(np.linspace(-2, 2, 4))
    log = model.diagram(omega=(1, 4, 3, "log"), **asked)
    np.testing.assert_allclose(log["omega"], [1, 2, 4], rtol=1e-15)
    import matplotlib

    matplotlib.use("Agg")
    assert log.plot().get_xlabel() and d.plot().collections


def test_a_sheared_picture_is_level(diagram):
    import matplotlib

    matplotlib.use("Agg")
    (line,) = diagram.plot(shear="auto").lines
    assert abs(np.polyfit(line.get_xdata(), line.get_ydata(), 1)[0]) < 1e-9
    (line,) = diagram.plot(shear=2.0).lines
    np.testing.assert_allclose(np.diff(diagram["y2"] - line.get_ydata()), 2 * np.diff(line.get_xdata()), atol=1e-12)


def test_what_is_set_gives_way_to_what_is_swept(valve):
    d = valve.with_values(q=0.03, r="0.8").diagram(q=(0.0201, 0.0206, 24), **ASKED)
    assert d.specification["set"] == [["r", "0.8"]]


def test_what_is_wrong_with_a_diagram_is_said_before_anything_is_begun(valve, tmp_path):
    with pytest.raises(ch.InputError, match="x.txt"):
        valve.diagram(out=tmp_path / "x.txt", q=(0.0201, 0.0206, 24), **ASKED)
    with pytest.raises(ch.InputError, match="x.txt"):
        valve.branches(q=(0.0201, 0.0206), out=tmp_path / "x.txt")
    assert not list(tmp_path.iterdir())
    with pytest.raises(ch.InputError, match=r"expected \(from, to, count\)"):
        valve.diagram(q=(0.0201, 0.0206), **ASKED)
    with pytest.raises(ch.InputError, match=r"2\.5"):
        valve.diagram(q=(0.0201, 0.0206, 2.5), **ASKED)


def test_shares_come_to_the_file_of_one_process(valve, tmp_path):
    whole = tmp_path / "whole.npz"
    asked = dict(q=(0.0201, 0.0206, 24), **ASKED)
    valve.diagram(out=whole, **asked)
    with pytest.warns(ch.ChatterWarning, match="pieces"):
        journals = [valve.diagram_shard(k, 3, out=tmp_path / "parts.npz", **asked) for k in (2, 1, 3)]
    with pytest.warns(ch.ChatterWarning, match="24 of 24"):
        merged = ch.merge(journals, tmp_path / "parts.npz")
    assert (tmp_path / "parts.npz").read_bytes() == whole.read_bytes()
    assert np.array_equal(merged["y2"], ch.resume(whole)["y2"])
    with pytest.warns(ch.ChatterWarning, match="pieces"):
        other = valve.diagram_shard(1, 3, out=tmp_path / "other.npz", **{**asked, "q": (0.0201, 0.0206, 25)})
    with pytest.raises(ch.InputError, match="another sweep"):
        ch.merge([journals[0], other], tmp_path / "both.npz")


def test_a_cluster_comes_to_the_file_of_one_process_though_a_worker_is_killed(valve, tmp_path):
    distributed = pytest.importorskip("distributed")
    asked = dict(q=(0.0201, 0.0206, 96), **dict(ASKED, transient=200))
    valve.diagram(out=tmp_path / "one.npz", **asked)
    killed = []

    def kill_one(*_):
        if not killed:
            killed.append(cluster.workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        found = valve.diagram(out=tmp_path / "many.npz", client=client, shards=6, progress=kill_one, **asked)
    assert killed
    assert (tmp_path / "many.npz").read_bytes() == (tmp_path / "one.npz").read_bytes()
    assert np.array_equal(found["y2"], ch.resume(tmp_path / "one.npz")["y2"])
    assert sorted(os.listdir(tmp_path)) == ["many.npz", "one.npz"]


def test_a_ball_that_loses_nothing_comes_back_to_its_height():
    ball = ch.Model.shipped("bouncing_ball").with_values(r=1)
    d = ball.diagram(sweep={"initial:y": (0.5, 1, 5)}, section="apex", observe="y", transient=3, keep=2)
    np.testing.assert_allclose(d["y"], np.repeat(np.linspace(0.5, 1, 5), 2), rtol=1e-12)
