#!/usr/bin/env python3
"""Columns of an orbit diagram of the valve by Chatter, heyoka (one at a time and in batches), DOP853 written by hand in C++,
and SciPy in one run.

    python3 benches/peers/columns.py

The work is that of the paper's Fig. 5: values of q from 0.02015 to 0.023, returns to the section y3 = 9.7 (falling), each
value from rest at release, 100 returns passed over and 200 kept. Everything runs on one core. Peers that are slow get fewer
columns or returns, spread over the same range; what is compared is returns per second. States are compared after each of
the first returns at the same values of q, before chaos has made anything of the last digit.
"""

import json
import subprocess
import time

from environment import ROOT, dop853, enter_environment, processor

KAPPA, DELTA, BETA, RESTITUTION = 1.25, 10.0, 20.0, 0.8
SECTION = 9.7
Q_FROM, Q_TO = 0.02015, 0.023
# The plug starts next to nothing above its seat: exactly on it, both peers step through.
START = [1e-30, 0.0, 10.0]
# States are compared at so many values of q, after so many returns. An impact that was stepped over shows as far more than
# this.
COMPARED, RETURNS, SAME = 16, 3, 1e-9
# Fig. 5 with 2000 values and 300 returns each.
FIGURE = 2000 * 300


def values(count):
    return [Q_FROM + (Q_TO - Q_FROM) * k / (count - 1) for k in range(count)]


def chatter(columns, transient, keep):
    command = ["cargo", "run", "--release", "-q", "-p", "chatter-dynamics", "--example", "valve_columns", "--"]
    counts = [str(count) for count in (columns, transient, keep)]
    done = subprocess.run([*command, *counts], cwd=ROOT, check=True, capture_output=True, text=True)
    answer = json.loads(done.stdout)
    samples, rate = answer["samples"], answer["returns_per_second"]
    return [samples[k : k + keep] for k in range(0, len(samples), keep)], rate


def equations(hy):
    y1, y2, y3 = hy.make_vars("y1", "y2", "y3")
    flight = [
        (y1, y2),
        (y2, -KAPPA * y2 - y1 - DELTA + y3),
        (y3, BETA * (hy.par[0] - y1 * hy.sqrt(y3))),
    ]
    return flight, y1, y3 - SECTION


def heyoka_scalar(columns, returns):
    import heyoka as hy

    flight, gap, surface = equations(hy)
    samples = []

    def collide(integrator, sign):
        state[0] = START[0]
        state[1] *= -RESTITUTION
        return len(samples[-1]) < returns

    def cross(integrator, at, sign):
        if len(samples[-1]) < returns:
            integrator.update_d_output(at)
            samples[-1].append(integrator.d_output[1])

    falling = hy.event_direction.negative
    integrator = hy.taylor_adaptive(
        flight,
        START,
        pars=[Q_FROM],
        t_events=[hy.t_event(gap, direction=falling, callback=collide)],
        nt_events=[hy.nt_event(surface, cross, direction=falling)],
    )
    # Views of its memory, made once.
    state, parameters = integrator.state, integrator.pars
    started = time.perf_counter()
    for q in values(columns):
        integrator.time, state[:], parameters[0] = 0.0, START, q
        integrator.reset_cooldowns()
        samples.append([])
        while len(samples[-1]) < returns:
            integrator.propagate_until(1e6)
    return samples, columns * returns / (time.perf_counter() - started)


def heyoka_batch(columns, returns):
    """Lanes that are done go on until the slowest is, and what they do is counted as well."""
    import heyoka as hy
    import numpy as np

    width = hy.recommended_simd_size()
    flight, gap, surface = equations(hy)
    samples = []

    def collide(integrator, sign, lane):
        state[0, lane] = START[0]
        state[1, lane] *= -RESTITUTION
        return True

    def cross(integrator, at, sign, lane):
        integrator.update_d_output(np.full(width, at))
        samples[-width + lane].append(integrator.d_output[1, lane])

    falling = hy.event_direction.negative
    integrator = hy.taylor_adaptive_batch(
        flight,
        np.repeat(np.array(START)[:, None], width, axis=1),
        pars=np.full((1, width), Q_FROM),
        t_events=[hy.t_event_batch(gap, direction=falling, callback=collide)],
        nt_events=[hy.nt_event_batch(surface, cross, direction=falling)],
    )
    state, parameters = integrator.state, integrator.pars
    started = time.perf_counter()
    qs = values(columns)
    for first in range(0, columns, width):
        integrator.set_time(0.0)
        state[:] = np.array(START)[:, None]
        parameters[0, :] = qs[first : first + width]
        integrator.reset_cooldowns()
        samples.extend([] for _ in range(width))
        # A return takes about three units of time.
        until = 3.0 * returns
        while min(map(len, samples[-width:])) < returns:
            integrator.propagate_until(np.full(width, until))
            until += 3.0
    spent = time.perf_counter() - started
    return samples, sum(map(len, samples)) / spent


def hand_written_dop853(columns, transient, keep):
    counts = [str(count) for count in (columns, transient, keep)]
    done = subprocess.run([dop853(), "columns", *counts], check=True, capture_output=True, text=True)
    answer = json.loads(done.stdout)
    samples, rate = answer["samples"], answer["returns_per_second"]
    return [samples[k : k + keep] for k in range(0, len(samples), keep)], rate


def scipy_dop853(columns, returns):
    import numpy as np
    from scipy.integrate import solve_ivp

    def seat(t, y, q):
        return y[0]

    def closing(t, y, q):
        return y[2] - SECTION

    def flight(t, y, q):
        return [y[1], -KAPPA * y[1] - y[0] - DELTA + y[2], BETA * (q - y[0] * np.sqrt(y[2]))]

    seat.terminal, seat.direction, closing.direction = True, -1, -1
    samples = []
    started = time.perf_counter()
    for q in values(columns):
        samples.append([])
        now, state = 0.0, list(START)
        while len(samples[-1]) < returns:
            events = [seat, closing]
            leg = solve_ivp(
                flight, (now, now + 10.0), state, method="DOP853", rtol=1e-12, atol=1e-14, events=events, args=(q,)
            )
            samples[-1].extend(crossed[1] for crossed in leg.y_events[1])
            now, state = leg.t[-1], leg.y[:, -1].copy()
            state[0], state[1] = START[0], -RESTITUTION * state[1]
    spent = time.perf_counter() - started
    return samples, sum(map(len, samples)) / spent


ROUNDS = 3

PEERS = {
    "Chatter": (chatter, (COMPARED, 0, RETURNS), (2000, 100, 200)),
    "C++ DOP853, 1e-10": (hand_written_dop853, (COMPARED, 0, RETURNS), (200, 100, 200)),
    "heyoka, one at a time": (heyoka_scalar, (COMPARED, RETURNS), (10, 300)),
    "heyoka, batch": (heyoka_batch, (COMPARED, RETURNS), (16, 300)),
    "SciPy DOP853, 1e-12": (scipy_dop853, (COMPARED, RETURNS), (4, 10)),
}


def main():
    enter_environment()
    print(processor())
    # Before anything is timed.
    answers = {name: run(*compare)[0] for name, (run, compare, _) in PEERS.items()}
    reference = answers["Chatter"]
    # In turn, so that whatever else the machine does in the meantime meets all.
    rates = dict.fromkeys(PEERS, 0.0)
    for _ in range(ROUNDS):
        for name, (run, _, work) in PEERS.items():
            rates[name] = max(rates[name], run(*work)[1])
    print(f"{'':24}{'returns/s':>10}{'Fig. 5':>10}{'same columns':>15}{'y2 off in these':>18}")
    for name, samples in answers.items():
        offs = [max(abs(a - b) for a, b in zip(one, two)) for one, two in zip(samples, reference)]
        same = [off for off in offs if off < SAME]
        rate = rates[name]
        agree = f"{len(same)} of {COMPARED}"
        print(f"{name:24}{rate:10.0f}{FIGURE / rate:8.1f} s{agree:>15}{max(same):18.1e}", flush=True)


if __name__ == "__main__":
    main()
