"""Trajectories against exact solutions, energy and themselves."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import chatter as ch

BALL = """
[parameters]
g = 9.81
r = 0.7
[flight]
y = "v"
v = "-g"
[[contact]]
name = "floor"
gap = "y"
impulse = { v = 1 }
restitution = "r"
[section.apex]
surface = "v"
direction = "falling"
[initial]
y = 2
v = 0
"""


@pytest.fixture
def ball():
    return ch.Model(BALL)


@pytest.fixture
def valve():
    return ch.Model.shipped("pressure_relief_valve").with_values(q=0.0195)


@pytest.mark.parametrize("r", [0.3, 0.55, 0.9])
@pytest.mark.parametrize("height", [0.1, 3.0])
def test_a_ball_comes_to_rest_when_the_sum_of_its_flights_says(ball, r, height):
    run = ball.with_values(r=r, y=height).simulate(1000, stop="accumulation:floor")
    fall = np.sqrt(2 * height / 9.81)
    assert run.outcome == "event" and run.success
    assert run.time == pytest.approx(fall * (1 + r) / (1 - r), rel=1e-14)
    assert run.events["accumulation"].time[0] == run.time
    first = run.events["impact:floor"]
    assert first.time[0] == pytest.approx(fall, rel=1e-14)
    np.testing.assert_allclose(first.rate_after, -r * first.rate_before, rtol=1e-13)
    # Between events to the rounding of a height.
    assert np.all(run["y"] > -1e-15 * height)


def test_energy_falls_by_the_restitution_at_impacts_alone(ball):
    run = ball.with_values(r=0.8).simulate(3)
    energy = run["v"] ** 2 / 2 + 9.81 * run["y"]
    before = run.events["impact"].time
    for start, end in zip([0.0, *before], [*before, 3.0]):
        within = energy[(run.t > start) & (run.t < end)]
        if len(within):
            np.testing.assert_allclose(within, within[0], rtol=1e-12)


def test_flights_are_those_of_solve_ivp(valve):
    impact = valve.simulate(40, impacts=1)

    def field(_, y):
        p = valve.parameters
        return [y[1], -p["kappa"] * y[1] - y[0] - p["delta"] + y[2], p["beta"] * (p["q"] - y[0] * np.sqrt(y[2]))]

    times = np.linspace(0, impact.time, 50)
    exact = solve_ivp(field, (0, impact.time), [0, 0, 10], method="DOP853", t_eval=times, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(impact(times), exact.y, atol=1e-11)


def test_dense_output_is_what_samples_say_to_the_bit(valve):
    run = valve.simulate(8)
    chosen = np.unique(run.t, return_index=True)[1]
    # Where several samples stand at one time there is an event.
    lone = np.array([k for k in chosen if np.sum(run.t == run.t[k]) == 1 and not np.any(run.closed[:, k])])
    np.testing.assert_allclose(run(run.t[lone]), run.y[:, lone], rtol=1e-12, atol=1e-13)
    even = valve.simulate(8, sample=0.25)
    assert np.array_equal(even(even.t), even.y)
    assert np.array_equal(valve.simulate(8, sample=even.t).y, even.y)
    shuffled = np.random.default_rng(1).permutation(len(even.t))
    assert np.array_equal(even(even.t[shuffled]), even.y[:, shuffled])
    assert run(np.reshape(even.t[:6], (2, 3))).shape == (3, 2, 3)
    assert run(1.0).shape == (3,)
    assert np.all(np.isnan(run([8.5, 9])))
    with pytest.raises(ch.InputError):
        run([-1.0])


def test_samples_are_where_they_are_asked_for(valve):
    for sample, count in [(0.5, 17), ("1/2", 17), ([0, 1, 1, 8], 4), (None, 0)]:
        run = valve.simulate(8, sample=sample)
        assert run.t.shape == (count,) and run.y.shape == (3, count) and run.closed.shape == (1, count)
    events = valve.simulate(8, sample="events")
    assert np.array_equal(events.t, events.events.time) and np.array_equal(events.y, events.events.y)
    assert np.all(np.diff(valve.simulate(8, sample="dense:3").t) >= 0)


def test_a_run_goes_on_where_another_ended(valve):
    whole = valve.simulate(20)
    first = valve.simulate(10)
    rest = valve.with_values(first.end).simulate(10)
    assert first.counts["impacts"] + rest.counts["impacts"] == whole.counts["impacts"]
    np.testing.assert_allclose(list(rest.end.values()), list(whole.end.values()), atol=1e-9)
    forced = ch.Model.shipped("impact_oscillator")
    first = forced.simulate(10)
    assert first.end["t"] == 10
    rest = forced.with_values(first.end).simulate(20)
    assert (rest.start_time, rest.time) == (10, 20)
    np.testing.assert_allclose(rest.y[:, -1], forced.simulate(20).y[:, -1], atol=1e-9)


def test_more_digits_are_there_in_the_low_part(ball):
    run = ball.with_values(g="9.81", r="0.5").simulate(stop="accumulation", digits=30)
    from decimal import Decimal, getcontext

    getcontext().prec = 40
    exact = 3 * (Decimal(4) / Decimal("9.81")).sqrt()
    assert abs(Decimal(run.digits["time"]) - exact) < Decimal("1e-28")
    last = Decimal(run.events.time[-1]) + Decimal(run.events.time_low[-1])
    assert abs(last - exact) < Decimal("1e-28")
    assert not np.any(ball.simulate(1).t_low)


def test_values_are_numbers_and_expressions(valve):
    a = valve.with_values(beta="2*delta", delta=11)
    assert a.parameters["beta"] == 22 and valve.parameters["delta"] == 10
    assert a.with_values(delta=12).parameters["beta"] == 24
    assert valve.with_values(q=np.float64(0.1) + 0.2).parameters["q"] == 0.1 + 0.2
    assert valve.with_values(q=np.array(0.3)).parameters["q"] == 0.3
    assert valve.with_values(y1=0.5).start["y1"] == 0.5
    table = {"q": [0.02, 0.021], "r": [0.7, 0.8]}
    assert [m.parameters["r"] for m in valve.over(table)] == [0.7, 0.8]


def test_tables_of_others(valve):
    run = valve.simulate(8)
    frame = run.to_pandas()
    assert list(frame.columns) == ["y1", "y2", "y3"] and np.array_equal(frame["y3"], run["y3"])
    data = run.to_xarray()
    assert data["y1"].attrs["long_name"] == "valve lift $y_1$" and data.attrs["q"] == 0.0195
    assert len(run.events.to_pandas()) == len(run.events)
    phases = run.contact_phases
    assert np.array_equal(phases.end[~np.isnan(phases.end)], run.events["release"].time)


def test_plots_take_and_give_axes(valve):
    import matplotlib

    matplotlib.use("Agg")
    run = valve.simulate(8)
    axes = run.plot("y1")
    assert run.plot("y2", ax=axes) is axes
    assert len(axes.lines) == 2
    assert np.array_equal(axes.lines[0].get_ydata(), run["y1"])
