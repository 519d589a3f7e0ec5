"""The mechanism drawn, against places computed by hand."""

import matplotlib
import numpy as np
import pytest

import chatter as ch

matplotlib.use("Agg")

PENDULUM = """
[parameters]
l = 2
[flight]
phi = "w"
w = "-sin(phi)"
[initial]
phi = 0.3
w = 0
[[drawing.rod]]
from = [0, 0]
to = ["l*sin(phi)", "-l*cos(phi)"]
[[drawing.mass]]
at = ["l*sin(phi)", "-l*cos(phi)"]
radius = 0.25
angle = "phi"
[[drawing.mass]]
at = ["t", 1]
size = [1, 0.5]
"""


def lines(axes, kind):
    return [np.transpose(line.get_data()) for line in axes.lines if line.get_label() == f"_{kind}"]


def test_a_pendulum_hangs_where_its_angle_says():
    pendulum = ch.Model(PENDULUM)
    run = pendulum.simulate(5)
    for t in (0.0, 1.7, 5.0):
        axes = run.draw(t)
        phi = run(t)[0]
        end = np.array([2 * np.sin(phi), -2 * np.cos(phi)])
        (rod,) = lines(axes, "rod")
        np.testing.assert_allclose(rod, [[0, 0], end], atol=1e-15)
        (disc,) = lines(axes, "disc")
        gap = np.flatnonzero(np.isnan(disc[:, 0]))[0]
        np.testing.assert_allclose(np.hypot(*(disc[:gap] - end).T), 0.25, rtol=1e-14)
        # Its mark is turned with it.
        np.testing.assert_allclose(disc[gap + 1 :], [end, end + 0.25 * np.array([np.cos(phi), np.sin(phi)])], atol=1e-15)
        # What depends on time moves though the equations do not know of it.
        (box,) = lines(axes, "mass")
        np.testing.assert_allclose([box.min(axis=0), box.max(axis=0)], [[t - 0.5, 0.75], [t + 0.5, 1.25]], atol=1e-15)
        assert axes.get_aspect() == 1
    np.testing.assert_allclose(lines(run.draw(), "rod")[0], rod, atol=1e-15)


def test_states_are_given_by_name_in_order_or_not_at_all():
    pendulum = ch.Model(PENDULUM)
    expected = lines(pendulum.draw([1.0, 0.0]), "rod")[0]
    np.testing.assert_allclose(expected[1], [2 * np.sin(1), -2 * np.cos(1)])
    np.testing.assert_array_equal(lines(pendulum.draw({"phi": 1.0}), "rod")[0], expected)
    np.testing.assert_array_equal(lines(pendulum.with_values(phi=1).draw(), "rod")[0], expected)
    axes = pendulum.draw()
    assert pendulum.with_values(l=3).draw(ax=axes) is axes and len(lines(axes, "rod")) == 2


def test_a_wall_has_its_hatches_on_the_right():
    # From left to right along y = 0: what is solid is below.
    axes = ch.Model.shipped("bouncing_ball").draw({"y": 2})
    (wall,) = lines(axes, "wall")
    np.testing.assert_array_equal(wall, [[-0.6, 0], [0.6, 0]])
    hatches = [line.get_ydata() for line in axes.lines if line.get_label() not in ("_wall", "_disc") and len(line.get_ydata())]
    assert len(hatches) == 1 and np.nanmax(hatches[0]) == 0 and np.nanmin(hatches[0]) < 0
    (ball,) = lines(axes, "disc")
    assert np.nanmax(ball[:, 1]) == pytest.approx(2.12)


def test_what_cannot_be_drawn_is_refused():
    ball = ch.Model.shipped("bouncing_ball")
    with pytest.raises(ch.InputError, match="`z` is no state"):
        ball.draw({"z": 1})
    with pytest.raises(ch.InputError, match="2 states are expected"):
        ball.draw([1.0])
    with pytest.raises(ch.InputError, match="nowhere at 3"):
        ball.simulate(1).draw(3)
    with pytest.raises(ch.InputError, match="no \\[drawing\\]"):
        ch.Model(PENDULUM[: PENDULUM.index("[[drawing")]).draw()
