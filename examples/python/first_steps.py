"""First steps: a trajectory through chatter, contact and release, its events, its picture.

    pip install '.[plot]' && python examples/python/first_steps.py
"""

import numpy as np

import chatter as ch

# A model that comes with chatter, with another flow rate and a parameter bound to another.
valve = ch.Model.shipped("pressure_relief_valve").with_values(q=0.0195, beta="2*delta")
print(valve.states, dict(valve.parameters))

# Followed until its tenth chatter sequence is complete: infinitely many impacts each.
run = valve.simulate(40, stop="accumulation:seat=10")
print(run.message, "at time", run.time)
print("released at", run.events["release"].time)

# Between release and the next one the orbit is the same every time: a period.
periods = np.diff(run.events["release"].time)
print("period", periods.mean(), "give or take", np.ptp(periods))
assert np.ptp(periods) < 1e-10

# The states at times of one's own, in any order.
print(run([0.5, 1.0, 1.5])[0])

# To thirty digits: the time at which a ball that is dropped from 1 m comes to rest is 3 sqrt(2 / 9.81) s.
ball = ch.Model.shipped("bouncing_ball").with_values(r="0.5")
print(ball.simulate(stop="accumulation", digits=30).digits["time"])

axes = run.plot("y1", "y2")
axes.set_xlim(0, 8)
axes.figure.savefig("first_steps.png", dpi=150)
