#!/usr/bin/env python3
"""The valve's trajectory by Chatter, heyoka, DOP853 written by hand in C++, and SciPy in one run.

    python3 benches/peers/trajectory.py

Makes a virtual environment beside this file, installs heyoka and SciPy into it from PyPI, builds Chatter, and follows the
same trajectory (q = 0.0203, from rest at release) with each, in turn, several times. Prints the best microseconds per impact
of each, and how far its time and state after 100 impacts are from Chatter's in the same number of impacts.
"""

import json
import subprocess
import time

from environment import ROOT, dop853, enter_environment, processor

Q, KAPPA, DELTA, BETA, RESTITUTION = 0.0203, 1.25, 10.0, 20.0, 0.8
COMPARED = 100


def chatter(impacts):
    command = ["cargo", "run", "--release", "-q", "-p", "chatter-dynamics", "--example", "valve_trajectory", "--"]
    done = subprocess.run([*command, str(impacts)], cwd=ROOT, check=True, capture_output=True, text=True)
    answer = json.loads(done.stdout)
    return answer["microseconds_per_impact"], answer["time"], answer["state"]


def heyoka_taylor(impacts):
    import heyoka as hy

    y1, y2, y3 = hy.make_vars("y1", "y2", "y3")
    left = [impacts]

    def collide(integrator, sign):
        # Started exactly on the wall it steps through it: start it next to nothing above.
        integrator.state[0] = 1e-30
        integrator.state[1] *= -RESTITUTION
        left[0] -= 1
        return left[0] > 0

    seat = hy.t_event(y1, direction=hy.event_direction.negative, callback=collide)
    flight = [
        (y1, y2),
        (y2, -KAPPA * y2 - y1 - DELTA + y3),
        (y3, BETA * (Q - y1 * hy.sqrt(y3))),
    ]
    integrator = hy.taylor_adaptive(flight, [1e-30, 0.0, 10.0], t_events=[seat])
    started = time.perf_counter()
    while left[0] > 0:
        integrator.propagate_until(integrator.time + 1e6)
    spent = time.perf_counter() - started
    return 1e6 * spent / impacts, integrator.time, list(integrator.state)


def hand_written_dop853(impacts):
    done = subprocess.run([dop853(), "trajectory", str(impacts)], check=True, capture_output=True, text=True)
    answer = json.loads(done.stdout)
    return answer["microseconds_per_impact"], answer["time"], answer["state"]


def scipy_dop853(impacts):
    import numpy as np
    from scipy.integrate import solve_ivp

    def flight(t, y):
        return [y[1], -KAPPA * y[1] - y[0] - DELTA + y[2], BETA * (Q - y[0] * np.sqrt(y[2]))]

    def seat(t, y):
        return y[0]

    seat.terminal, seat.direction = True, -1
    now, state = 0.0, [1e-30, 0.0, 10.0]
    started = time.perf_counter()
    for _ in range(impacts):
        leg = solve_ivp(flight, (now, now + 10.0), state, method="DOP853", rtol=1e-12, atol=1e-14, events=seat)
        now, state = leg.t[-1], leg.y[:, -1].copy()
        state[0], state[1] = 1e-30, -RESTITUTION * state[1]
    spent = time.perf_counter() - started
    return 1e6 * spent / impacts, now, list(state)


ROUNDS = 3

PEERS = {
    "Chatter": (chatter, 300_000),
    "C++ DOP853, 1e-10": (hand_written_dop853, 300_000),
    "heyoka": (heyoka_taylor, 100_000),
    "SciPy DOP853, 1e-12": (scipy_dop853, COMPARED),
}


def main():
    enter_environment()
    print(processor())
    chatter(1)
    _, end, reference = chatter(COMPARED)
    offs = {}
    for name, (run, _) in PEERS.items():
        _, at, state = run(COMPARED)
        offs[name] = abs(at - end), max(abs(a - b) for a, b in zip(state[1:], reference[1:]))
    # In turn, so that whatever else the machine does in the meantime meets all.
    speeds = dict.fromkeys(PEERS, float("inf"))
    for _ in range(ROUNDS):
        for name, (run, impacts) in PEERS.items():
            speeds[name] = min(speeds[name], run(impacts)[0])
    print(f"{'':24}{'us per impact':>16}{'time off':>12}{'state off':>12}   after {COMPARED} impacts")
    for name, (late, off) in offs.items():
        print(f"{name:24}{speeds[name]:16.2f}{late:12.1e}{off:12.1e}")


if __name__ == "__main__":
    main()
