#!/usr/bin/env python3
"""A branch of periodic orbits of the valve by Chatter and by collocation with SciPy's `solve_bvp`, in turn.

    python3 benches/peers/orbit.py [--chatter PROGRAM]

The orbit of 34 impacts a period at q = 0.0203. SciPy solves what multi-segment collocation (COCO, AUTO) would: each flight on
its own unit of time, their durations among the unknowns, the sequence of impacts given by hand, Jacobians given. Its first
guess at each q is the orbit at the one before. Chatter follows the branch by its arc length, with multipliers and a watch for
grazes at each orbit. The time of its process less that of finding the first orbit is told.
"""

import argparse
import json
import subprocess
import time

from environment import ROOT, enter_environment

KAPPA, DELTA, BETA, RESTITUTION = 1.25, 10.0, 20.0, 0.8
Q, WIDTH = 0.0203, 2e-5
TOLERANCE = 1e-6
ROUNDS, POINTS = 3, 4


def program(given):
    if given:
        return given
    subprocess.run(["cargo", "build", "--release", "-q", "-p", "chatter-cli"], cwd=ROOT, check=True)
    return str(ROOT / "target" / "release" / "chatter")


def run(chatter, *arguments):
    started = time.perf_counter()
    done = subprocess.run([chatter, *arguments, "--json"], check=True, capture_output=True, text=True)
    return time.perf_counter() - started, json.loads(done.stdout)


def orbit(chatter, q):
    return run(chatter, "orbit", "pressure_relief_valve", "--set", f"q={q!r}")


def branch(chatter):
    sweep = f"q={Q - WIDTH!r}:{Q + WIDTH!r}"
    return run(chatter, "continue", "pressure_relief_valve", "--set", f"q={Q!r}", "--sweep", sweep, "--step", "0.002")


class Collocation:
    """The orbit as flights, from each impact to the next."""

    def __init__(self, found):
        import numpy as np

        self.np = np
        impacts = [event for event in found["events"] if event["kind"] == "impact"]
        times = np.array([event["time"] for event in impacts])
        states = np.array([[0.0, event["rate_after"], event["state"]["y3"]] for event in impacts])
        self.count = len(impacts)
        following = np.append(times[1:], times[0] + found["period"])
        self.durations = following - times
        self.nodes = np.linspace(0.0, 1.0, 9)
        self.values = np.zeros((3 * self.count, len(self.nodes)))
        from scipy.integrate import solve_ivp

        for k, (start, duration) in enumerate(zip(states, self.durations)):
            flown = solve_ivp(
                lambda _, y: self.flight(y, Q), (0, duration), start, "DOP853", self.nodes * duration, rtol=1e-10, atol=1e-12
            )
            self.values[3 * k : 3 * k + 3] = flown.y

    def flight(self, y, q):
        np = self.np
        return np.array([y[1], -KAPPA * y[1] - y[0] - DELTA + y[2], BETA * (q - y[0] * np.sqrt(np.abs(y[2])))])

    def solve(self, q):
        """The period of the orbit, and the seconds that it took."""
        from scipy.integrate import solve_bvp

        np, count = self.np, self.count

        def field(_, y, durations):
            parts = self.flight(y.reshape(count, 3, -1).transpose(1, 0, 2), q)
            return (parts * durations[:, None]).transpose(1, 0, 2).reshape(3 * count, -1)

        def field_slopes(_, y, durations):
            points = y.shape[1]
            x = y.reshape(count, 3, points)
            slopes = np.zeros((3 * count, 3 * count, points))
            by_duration = np.zeros((3 * count, count, points))
            rates = self.flight(x.transpose(1, 0, 2), q)
            for k, duration in enumerate(durations):
                root = np.sqrt(np.abs(x[k, 2]))
                i = 3 * k
                slopes[i, i + 1] = duration
                slopes[i + 1, i] = -duration
                slopes[i + 1, i + 1] = -KAPPA * duration
                slopes[i + 1, i + 2] = duration
                slopes[i + 2, i] = -BETA * root * duration
                slopes[i + 2, i + 2] = -BETA * x[k, 0] / (2 * root) * duration
                by_duration[i : i + 3, k] = rates[:, k]
            return slopes, by_duration

        def ends(start, end, _):
            a, b = start.reshape(count, 3), end.reshape(count, 3)
            after = np.roll(a, -1, axis=0)
            closed = np.stack([a[:, 0], b[:, 0], after[:, 1] + RESTITUTION * b[:, 1], after[:, 2] - b[:, 2]])
            return closed.ravel()

        started = time.perf_counter()
        found = solve_bvp(
            field, ends, self.nodes, self.values, self.durations, fun_jac=field_slopes, tol=TOLERANCE, max_nodes=1000
        )
        spent = time.perf_counter() - started
        if not found.success:
            raise SystemExit(f"solve_bvp: {found.message}")
        self.nodes, self.values, self.durations = found.x, found.y, found.p
        return found.p.sum(), spent


def main():
    enter_environment()
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--chatter")
    chatter = program(arguments.parse_args().chatter)
    first, told = orbit(chatter, Q)
    peer = Collocation(told["orbit"])
    ours, theirs, off = [], [], 0.0
    for index in range(ROUNDS):
        alone = min(orbit(chatter, Q)[0] for _ in range(2))
        whole, branches = branch(chatter)
        points = len(branches["branches"][0]["points"]["q"])
        ours.append(points / (whole - alone))
        spent = 0.0
        for step in range(POINTS):
            q = Q + 1e-7 * (index * POINTS + step)
            period, seconds = peer.solve(q)
            spent += seconds
        theirs.append(POINTS / spent)
        exact = orbit(chatter, q)[1]["orbit"]["period"]
        off = max(off, abs(period - exact))
    print(f"{'':32}{'orbits a second':>16}{'period off':>12}")
    print(f"{'chatter continue':32}{max(ours):16.1f}")
    print(f"{'SciPy solve_bvp ' + format(TOLERANCE, '.0e'):32}{max(theirs):16.3f}{off:12.1e}")


if __name__ == "__main__":
    main()
