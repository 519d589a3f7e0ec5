"""What the package was asked to be, line by line as it was written down; but sweeps have fewer values, curves are bounded, and files
lie in a folder."""

import matplotlib
import numpy as np
import pytest

import chatter as ch

matplotlib.use("Agg")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_run(folder):
    valve = ch.Model.shipped("pressure_relief_valve").with_values(q=0.0195, beta="2*delta")
    run = valve.simulate(40, stop="accumulation:seat=10")
    assert len(run.t) == run.y.shape[1] == len(run["y1"]) and run.y.shape[0] == 3
    assert run.outcome == "event" and len(run.events["release"].time) == 9
    assert len(run.to_pandas()) == len(run.t) and run.to_xarray()["y1"].shape == run.t.shape
    assert run.plot() is not None
    times = np.linspace(0, 3, 7)
    assert run(times).shape == (3, 7)
    np.testing.assert_allclose(run(run.t)[0], run["y1"], atol=1e-12)


def test_a_diagram(folder):
    valve = ch.Model.shipped("pressure_relief_valve").with_values(q=0.0195, beta="2*delta")
    d = valve.diagram(q=(0.0201, 0.0235, 40), observe="y2", start="carry", progress=True, journal="fig5.journal", transient=20)
    assert d.orbit(17).parameters["q"] == d["q"][17]
    assert d.plot() is not None
    written = valve.diagram(q=(0.0201, 0.0235, 40), observe="y2", start="carry", transient=20, out="fig5.npz")
    again = ch.resume("fig5.npz")
    for name in [*d.columns, *d.samples]:
        assert np.array_equal(d[name], written[name]) and np.array_equal(d[name], again[name]), name


def test_theory():
    U = ch.Universal(0.8)
    assert U(np.geomspace(1e-5, 1, 1000)).shape == (1000,)
    valve = ch.Model.shipped("pressure_relief_valve").with_values(q=0.0195, beta="2*delta")
    border = valve.border("q", near=0.02, digits=30)
    assert border.value == pytest.approx(0.0200560057, abs=1e-9)
    assert len(str(border.decimal("value"))) >= 30


def test_orbits_and_branches():
    valve = ch.Model.shipped("pressure_relief_valve").with_values(q=0.0195, beta="2*delta")
    # The motion is chaotic there: an unstable orbit of one period.
    orbit = valve.orbit(q=0.0215)
    assert not orbit.stable and orbit.period == pytest.approx(3.52, abs=0.01)
    branch = orbit.follow("q", to=0.0235)
    # It turns back at a graze. A part of the range that the curve would have without bounds, which takes long.
    curve = branch.special["flight_graze"][0].follow("q", "r", low=0.799, high=0.8)
    assert curve.kind == "flight_graze" and len(curve) > 2
    d = valve.diagram(q=(0.0201, 0.0235, 20), observe="y2", keep=20, transient=20)
    axes = branch.plot(ax=d.plot())
    assert len(axes.lines) >= 3 and axes.get_xlabel() == "flow rate $q$"
