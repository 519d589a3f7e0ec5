"""Models from texts, files, operators and SymPy; what is wrong with them; what results are made of."""

import copy
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import chatter as ch


def ball_of(sympy_too):
    b = ch.ModelBuilder("Bouncing ball", source="Galilei 1638")
    g, r = b.parameter("g", 9.81), b.parameter("r", 0.5)
    y, v = b.state("y", 1, label=("height", "m")), b.state("v", 0)
    b.flow(y, v)
    b.flow(v, -g)
    b.contact("floor", gap=y, impulse={v: 1}, restitution=r)
    b.section("apex", v, "falling")
    return b


def test_a_built_model_is_the_one_that_is_written():
    built = ball_of(False).build()
    assert built.title == "Bouncing ball" and built.states == ("y", "v")
    text = ball_of(False).text()
    assert ch.Model(text).simulate(3).time == built.simulate(3).time
    shipped = ch.Model.shipped("bouncing_ball").with_values(y=1, v=0, g=9.81, r=0.5).simulate(stop="accumulation")
    assert built.simulate(stop="accumulation").time == shipped.time


def value_of(expression, **names):
    """What the model language takes an expression for."""
    b = ch.ModelBuilder()
    for name, value in names.items():
        b.parameter(name, value)
    b.parameter("result", expression)
    x = b.state("x")
    b.flow(x, 1)
    return b.build().parameters["result"]


NUMBERS = dict(a=1.7, b=-0.6, c=2.3)


@pytest.mark.parametrize(
    "make",
    [
        lambda a, b, c, f: a - (b - c),
        lambda a, b, c, f: a - b - c,
        lambda a, b, c, f: a / (b / c) / 3,
        lambda a, b, c, f: -(a**2) + (-a) ** 2 * 3,
        lambda a, b, c, f: (a + b) * c - 2 * (c - 1),
        lambda a, b, c, f: a ** (b + 1) ** 2,
        lambda a, b, c, f: 2**a / (-c),
        lambda a, b, c, f: f.sin(a) * f.cos(b) - f.exp(b) / f.sqrt(c) + f.log(c) + f.atan2(a, b),
        lambda a, b, c, f: abs(b - a) + f.tanh(c) - (+a),
        lambda a, b, c, f: 1 - a * -b + 1e-30 + 0.1,
    ],
)
def test_operators_mean_in_a_model_what_they_mean_in_python(make):
    import math

    expected = make(*NUMBERS.values(), math)
    found = value_of(make(*(ch.expr(name) for name in NUMBERS), ch), **NUMBERS)
    assert found == pytest.approx(expected, rel=1e-14)


def test_sympy_means_the_same():
    sympy = pytest.importorskip("sympy")
    a, b, c = sympy.symbols("a b c")
    expressions = [
        a - (b - c), a / b / c, -(a**2), sympy.sqrt(c) + sympy.exp(b), sympy.Rational(1, 3) * a, sympy.Abs(b) ** a,
        sympy.Piecewise((a, b > 0), (c, True)), sympy.Piecewise((a, (b > 0) & (c < 5)), (b, (a > 9) | (c < b)), (c, True)),
        sympy.Piecewise((a, sympy.Not((b > 0) & (a > 0))), (c, True)), sympy.Max(a, b, c), sympy.sin(sympy.pi * a) + sympy.Float("0.1"),
        sympy.diff(sympy.sin(a * b) * c**2, a), 1 / (1 + a**2), sympy.E**c,
    ]  # fmt: skip
    for expression in expressions:
        assert value_of(expression, **NUMBERS) == pytest.approx(float(expression.subs(NUMBERS)), rel=1e-13), expression
    with pytest.raises(ch.InputError, match="gamma"):
        value_of(sympy.gamma(a), **NUMBERS)


def test_conditions_choose():
    a = ch.expr("a")
    chosen = ch.if_((a > 1) & ~(a >= 2), 10, ch.if_((a < 0) | (a > 5), 20, 30))
    assert [value_of(chosen, a=x) for x in (1.5, 3, -1, 6, 0.5)] == [10, 30, 20, 20, 30]
    with pytest.raises(TypeError):
        bool(a > 1)


def test_what_is_wrong_is_told_with_its_place():
    text = '[flight]\nx = "vv"\nv = "-x +"\n\n[initial]\nx = 1\nv = 0\n'
    with pytest.raises(ch.ModelError) as caught:
        ch.Model(text)
    errors = caught.value.errors
    assert [(error.line, error.column) for error in errors] == [(2, 6), (3, 10)]
    assert "vv" in errors[0].message and "^" in errors[0].text
    assert pickle.loads(pickle.dumps(caught.value)).errors == errors
    with pytest.raises(ch.ModelError, match="value of q"):
        ch.Model.shipped("pressure_relief_valve").with_values(q="kapp")
    with pytest.raises(ValueError, match="did you mean `bouncing_ball`"):
        ch.Model.shipped("bouncing_bal")
    with pytest.raises(ch.InputError) as refused:
        ch.Model.shipped("bouncing_ball").simulate(stop="impakt")
    assert "did you mean `impact`" in refused.value.message
    with pytest.raises(ch.InputError):
        ch.Model.shipped("bouncing_ball").with_values(r=float("nan"))


def test_more_samples_than_memory_is_to_keep_are_refused():
    ball = ch.Model.shipped("bouncing_ball")
    with pytest.raises(ch.InputError, match=r"5\.0e12 samples, about .* are more than is kept in memory"):
        ball.simulate(5, sample=1e-12)
    assert len(ball.simulate(0.5, sample=1e-3).t) >= 500


def test_a_run_that_cannot_go_on_has_what_was_computed():
    falling = ch.Model('[flight]\nx = "-1/x"\n[initial]\nx = 1\n')
    with pytest.raises(ch.RunError) as caught:
        falling.simulate(2)
    run = caught.value.run
    assert not run.success and run.message == str(caught.value)
    np.testing.assert_allclose(run["x"], np.sqrt(np.maximum(1 - 2 * run.t, 0)), atol=1e-6)
    assert run.time == pytest.approx(0.5, abs=1e-6)


def test_results_are_frozen_and_can_be_pickled():
    valve = ch.Model.shipped("pressure_relief_valve").with_values(q=0.0195)
    run = valve.simulate(8)
    diagram = valve.diagram(q=(0.0202, 0.0203, 3), observe="y2", transient=5, keep=4)
    border = valve.border("q", near=0.02, windows=(20, 20))
    for result in [valve, run, run.events, diagram, diagram.orbit(1), border, ch.Universal(0.8), ch.expr("a") + 1]:
        again = pickle.loads(pickle.dumps(result))
        assert repr(again) == repr(result)
        copy.deepcopy(result)
    again = pickle.loads(pickle.dumps(run))
    assert np.array_equal(again.y, run.y) and again.model == valve and np.array_equal(again(run.t[:5]), run(run.t[:5]))
    for array in [run.t, run.y, again.y, run.events.time, diagram["y2"]]:
        with pytest.raises(ValueError):
            array[...] = 0
    with pytest.raises(AttributeError):
        run.t = 3
    with pytest.raises(AttributeError):
        valve.text = ""


def test_a_file_and_the_tables_beside_it(tmp_path):
    (tmp_path / "cam.csv").write_text("x,y\n-1,-2\n1,2\n3,-2\n")
    (tmp_path / "cam.toml").write_text(
        '[table.lift]\nfile = "cam.csv"\n[flight]\nx = "lift(t)"\n[initial]\nx = 0\n'
    )
    model = ch.Model.from_file(tmp_path / "cam.toml")
    moved = pickle.loads(pickle.dumps(model))
    (tmp_path / "cam.csv").unlink()
    assert moved.simulate(2).end["x"] == pytest.approx(2, abs=1e-13)
    with pytest.raises(ch.InputError, match="there is no file"):
        ch.Model.from_file(tmp_path / "none.toml")


def test_every_shipped_model_runs():
    for name in ch.shipped_models():
        assert ch.Model.shipped(name).simulate(0.5).success


@pytest.mark.parametrize(
    "work",
    [
        "ch.Model.shipped('pressure_relief_valve').simulate(1e9, impacts=10**12, sample=None)",
        "ch.Model.shipped('pressure_relief_valve').diagram(q=(0.0201, 0.0235, 100000), observe='y2')",
        "ch.Model.shipped('impact_oscillator').borders('sigma', -1, 1, samples=10**7)",
    ],
)
def test_ctrl_c_is_heard_within_a_fraction_of_a_second(work):
    # What starts these tests may have told its children to ignore Ctrl-C.
    hears = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    program = f"{hears}; import sys, chatter as ch; print('on', flush=True); {work}"
    process = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "on\n"
    time.sleep(1)
    asked = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=20)
    # Computations stop within a tenth of a second and the interpreter within half, on a machine that has nothing else to do.
    assert time.monotonic() - asked < 5
    assert "KeyboardInterrupt" in said


def test_other_threads_run_meanwhile():
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.005)

    thread = threading.Thread(target=count)
    thread.start()
    began = time.monotonic()
    ch.Model.shipped("pressure_relief_valve").simulate(3000, sample=None)
    elapsed = time.monotonic() - began
    done.set()
    thread.join()
    assert counted > elapsed / 0.05


def test_progress_is_told():
    heard = []
    ch.Model.shipped("pressure_relief_valve").simulate(
        10000, sample=None, progress=lambda done, message: heard.append((done, message))
    )
    assert heard and all(0 <= done <= 1 for done, _ in heard)
    assert [done for done, _ in heard] == sorted(done for done, _ in heard)


def test_the_command_is_there():
    said = subprocess.run([sys.executable, "-m", "chatter", "--version"], capture_output=True, text=True)
    assert said.stdout == f"chatter {ch.__version__}\n" and said.returncode == 0
    said = subprocess.run([sys.executable, "-m", "chatter", "simulate", "nothing"], capture_output=True, text=True)
    assert said.returncode == 2 and "error:" in said.stderr
