"""A model of your own: a ball on a table that shakes, from operators, and once more from SymPy.

    pip install '.[plot,sympy]' && python examples/python/your_own_model.py
"""

import sympy

import chatter as ch

# With operators.
b = ch.ModelBuilder("Ball on a shaking table")
amplitude = b.parameter("amplitude", 0.02, label=("amplitude", "m"))
omega = b.parameter("omega", "2*pi*5")
r = b.parameter("r", 0.6, label="restitution $r$")
table = b.define("table", amplitude * ch.sin(omega * ch.time))
y, v = b.state("y", 0.3, label=("height", "m")), b.state("v", 0, label=("velocity", "m/s"))
b.flow(y, v)
b.flow(v, -9.81)
b.contact("table_top", gap=y - table, impulse={v: 1}, restitution=r)
ball = b.build()
print(b.text())

run = ball.simulate(10)
print(run)

# The same equations from a Lagrangian, by SymPy.
t, g, m = sympy.symbols("t g m", positive=True)
q = sympy.Function("q")(t)
lagrangian = m * q.diff(t) ** 2 / 2 - m * g * q
force = lagrangian.diff(q) - lagrangian.diff(q.diff(t)).diff(t).subs(q.diff(t, 2), 0)
acceleration = sympy.simplify(force / m)

b = ch.ModelBuilder("Ball on a shaking table, by SymPy")
b.parameter(g, 9.81)
A, w = sympy.symbols("amplitude omega")
b.parameter(A, 0.02)
b.parameter(w, "2*pi*5")
b.state(q, 0.3)
speed = b.state("v", 0)
b.flow(q, speed)
b.flow(speed, acceleration)
b.contact("table_top", gap=q - A * sympy.sin(w * t), impulse={speed: 1}, restitution=0.6)
again = b.build().simulate(10)
assert abs(again.end["q"] - run.end["y"]) < 1e-9 * abs(run.counts["impacts"])

# What it settles to, for stronger and stronger shaking.
diagram = ball.diagram(amplitude=(0.005, 0.02, 60), observe="v", period="2*pi/omega", transient=100, keep=30)
print(diagram)
diagram.plot().figure.savefig("your_own_model.png", dpi=150)
