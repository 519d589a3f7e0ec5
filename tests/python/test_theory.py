"""The universal function and border orbits against their laws."""

import json
import pickle
import subprocess
import sys
from decimal import Decimal

import numpy as np
import pytest

import chatter as ch


@pytest.mark.parametrize("r", [0.4, 0.8])
def test_upsilon_is_self_similar_and_differentiable(r):
    upsilon = ch.Universal(r)
    x = np.geomspace(1e-4, 1e-2, 40).reshape(8, 5)
    values = upsilon(x)
    assert values.shape == x.shape
    ratio = upsilon(upsilon.eta * x) / values
    np.testing.assert_allclose(ratio, upsilon.eta**upsilon.exponent, rtol=1e-10)
    step = 1e-6 * x
    inside = upsilon.lap(x - step) == upsilon.lap(x + step)
    difference = (upsilon(x + step) - upsilon(x - step)) / (2 * step)
    np.testing.assert_allclose(upsilon.derivative(x)[inside], difference[inside], rtol=1e-4, atol=1e-6)
    assert upsilon(-1.0) == 0 and np.all(np.isinf(upsilon.lap([0.0, -1])))


@pytest.mark.parametrize("slope", [1.0, 0.7])
def test_a_fixed_point_of_a_window_is_stable_and_superstable_where_it_says(slope):
    upsilon = ch.Universal(0.8)
    windows = upsilon.windows(slope, 3, 6)
    x = np.geomspace(1e-8, 1, 400_000)

    def multipliers(mu):
        off = upsilon(x) - (x - mu) / slope
        place = np.flatnonzero(np.diff(np.sign(off)))
        return slope * upsilon.derivative(x[place])

    for fold, superstable, doubling in zip(windows["fold"], windows["superstable"], windows["period_doubling"]):
        assert np.min(np.abs(multipliers(superstable))) < 1e-2
        for end, multiplier in [(fold, 1), (doubling, -1)]:
            inside = end + 1e-3 * (superstable - end)
            assert np.min(np.abs(multipliers(inside) - multiplier)) < 0.1
            assert np.any(np.abs(multipliers(inside)) < 1)


def test_a_restitution_that_is_none_is_refused():
    with pytest.raises(ch.InputError):
        ch.Universal(1.5)


def test_a_border_is_that_of_the_command():
    valve = ch.Model.shipped("pressure_relief_valve")
    border = valve.border("q", near=0.02, windows=(20, 20), digits=25)
    asked = ["border", "pressure_relief_valve", "--parameter", "q", "--near", "0.02", "--windows", "20:20", "--json"]
    said = subprocess.run(
        [sys.executable, "-m", "chatter", *asked, "--digits", "25"], check=True, capture_output=True, text=True
    )
    assert border.document == json.loads(said.stdout)
    assert abs(border.decimal("value") - Decimal(border.value)) < Decimal("1e-17")
    # Complete chatter on one side of it, none on the other.
    ends = [valve.with_values(q=border.value + off).simulate(20, sample=None) for off in (-1e-5, 1e-5)]
    kinds = [run.counts["accumulations"] > 1 for run in ends]
    assert kinds == [True, False]


def test_a_search_without_border_says_so():
    with pytest.raises(ch.ChatterError):
        ch.Model.shipped("pressure_relief_valve").border("q", near=1e9)


def test_a_periodic_orbit_returns_to_where_it_started():
    valve = ch.Model.shipped("pressure_relief_valve")
    orbit = valve.orbit(q=0.0203)
    assert orbit.stable and np.all(np.abs(orbit.multipliers) < 1)
    run = orbit.model.with_values(orbit.start).simulate(orbit.period, sample=None)
    np.testing.assert_allclose(list(run.end.values()), list(orbit.start.values()), atol=1e-9)
    # A linear system has the multipliers of its own: exp of eigenvalues times period.
    forced = ch.Model('[flight]\nx = "v"\nv = "cos(2*t) - 0.2*v - x"\n[initial]\nx = 0\nv = 0\n')
    orbit = forced.orbit(period="pi")
    eigenvalues = np.linalg.eigvals(np.array([[0, 1], [-1, -0.2]]))
    expected = np.sort_complex(np.exp(eigenvalues * np.pi))
    np.testing.assert_allclose(np.sort_complex(orbit.multipliers), expected, rtol=1e-9)
    assert orbit.stable and not orbit.neutral
    # Without damping it is neither.
    free = ch.Model('[flight]\nx = "v"\nv = "cos(2*t) - x"\n[initial]\nx = 0\nv = 0\n')
    (orbit,) = free.orbits(1, starts=5, period="pi")
    assert orbit.neutral and not orbit.stable and "neutral" in repr(orbit)
    text = '[parameters]\nw = 1.637\nc = 0\n[flight]\nx = "v"\nv = "cos(w*t) - c*v - x"\n[initial]\nx = 0\nv = 0\n'
    for damping, stable, neutral in [(0, False, True), (0.1, True, False), (-0.1, False, False)]:
        (branch,) = ch.Model(text).with_values(c=damping).branches(w=(1.6, 1.7), all=1, starts=3, step=0.1)
        assert np.all(branch["stable"] == stable) and np.all(branch["neutral"] == neutral)


def test_a_branch_holds_the_orbits_of_its_parameter():
    valve = ch.Model.shipped("pressure_relief_valve")
    branch = valve.orbit(q=0.0203).follow("q", to=0.0204)
    assert np.all((branch["q"] >= 0.0203 - 1e-15) & (branch["q"] <= 0.0204 + 1e-15))
    k = len(branch) // 2
    start = {name: branch[name][k] for name in valve.states}
    at = valve.with_values(start, q=branch["q"][k])
    run = at.simulate(branch["period"][k], sample=None)
    np.testing.assert_allclose(list(run.end.values()), list(start.values()), atol=1e-6)
    assert run.counts["impacts"] == branch["impacts"][k] or branch["impacts"][k] == -1
    for kind, found in branch.special.items():
        assert all(0.0203 <= one["value"] <= 0.0204 for one in found), kind


def test_an_unstable_orbit_is_followed_and_no_other():
    oscillator = ch.Model.shipped("impact_oscillator").with_values(omega=2.8)
    unstable = next(orbit for orbit in oscillator.orbits(1, starts=20) if not orbit.stable)
    branch = unstable.follow("omega", to=2.79)
    begins = int(np.argmax(branch["omega"]))
    assert branch["omega"][begins] == pytest.approx(2.8, abs=1e-12)
    # Time is known up to whole periods.
    for name in unstable.start.keys() - {"t"}:
        assert branch[name][begins] == pytest.approx(unstable.start[name], abs=1e-9), name
    assert branch["impacts"][begins] == unstable.impacts and not branch["stable"][begins]
    with pytest.raises(ch.InputError, match="step"):
        unstable.follow("omega", to=2.79, step=2)
    with pytest.raises(ch.InputError, match="periods"):
        oscillator.orbits(0)


def test_exponents_are_the_logarithms_of_the_multipliers_of_a_stable_orbit():
    valve = ch.Model.shipped("pressure_relief_valve")
    orbit = valve.orbit(q=0.0203)
    at = orbit.model.with_values(orbit.start)
    found = at.exponents(interval=orbit.period, transient=60, intervals=40)
    along, across = 0.0, np.log(abs(orbit.multipliers[0])) / orbit.period
    np.testing.assert_allclose(found.values[:2], [along, across], atol=1e-6)
    assert found.intervals == 40 and found.time == pytest.approx(40 * orbit.period)
    assert pickle.loads(pickle.dumps(found)).values.tolist() == found.values.tolist()
    with pytest.raises(ch.InputError, match="interval"):
        valve.exponents(interval=-1)


def test_special_points_can_be_followed_in_two_parameters():
    valve = ch.Model.shipped("pressure_relief_valve")
    branch = valve.orbit(q=0.0203).follow("q", to=0.0204)
    special = branch.special["period_doubling"][0]
    curve = special.follow("q", "kappa", low=1.249, high=1.251)
    assert len(curve) > 3 and np.all((curve["kappa"] >= 1.249 - 1e-12) & (curve["kappa"] <= 1.251 + 1e-12))
    # A multiplier is -1 all along, and the point itself lies on the curve.
    assert max(np.abs(multipliers + 1).min() for multipliers in curve.points["multipliers"]) < 1e-6
    order = np.argsort(curve["kappa"])
    assert np.interp(1.25, curve["kappa"][order], curve["q"][order]) == pytest.approx(special["value"], rel=1e-6)
    assert pickle.loads(pickle.dumps(curve))["q"].tolist() == curve["q"].tolist()
    assert pickle.loads(pickle.dumps(branch)).special["period_doubling"][0]["value"] == special["value"]
    with pytest.raises(ch.InputError, match="two parameters"):
        special.follow("q", "q")


def test_a_branch_tells_its_arcs_and_watches_functions():
    oscillator = ch.Model.shipped("impact_oscillator").with_values(omega=0.6081, r=0.5)
    branch = oscillator.orbit().follow("omega", to=0.609, impacts=11, monitors=["omega - 0.6085"])
    assert len(branch.arcs) > 1 and all(len(branch["period"][arc.points]) for arc in branch.arcs)
    for arc in branch.arcs:
        assert np.all(branch["impacts"][arc.points] == arc.impacts)
        values = branch["omega"][arc.points]
        assert arc.low <= values.min() and values.max() <= arc.high
    # From arc to arc by a graze, which is one of both.
    for one, other in zip(branch.arcs, branch.arcs[1:]):
        assert abs(one.impacts - other.impacts) == 1
        assert one.special[-1] is other.special[0] and "graze" in one.special[-1]["kind"]
    for zero in branch.special["monitor"]:
        assert zero["value"] == pytest.approx(0.6085, abs=1e-13) and zero["monitor"] == "omega - 0.6085"
    np.testing.assert_allclose(branch["omega - 0.6085"], branch["omega"] - 0.6085, atol=1e-15)
    assert pickle.loads(pickle.dumps(branch)).arcs[0].impacts == branch.arcs[0].impacts
