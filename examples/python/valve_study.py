"""A study of the relief valve: where does complete chatter end, and what comes after?

    pip install '.[plot]' && python examples/python/valve_study.py
"""

import numpy as np

import chatter as ch

valve = ch.Model.shipped("pressure_relief_valve")

# The border orbit: its chatter ends exactly at release. Left of it the plug comes to rest on its seat.
border = valve.border("q", near=0.02, windows=(20, 24))
print(f"complete chatter ends at q = {border.value:.12f} +- {border.error:.1e}")

# Right of it the dynamics are those of z -> Upsilon(K z + mu), and windows of period one follow each other.
for predicted, found in zip(border.document["windows"], border.document["simulated_windows"]):
    print(f"n = {found['n']}: born at {found['fold']}, predicted {predicted['fold']}")

# The diagram of what orbits settle to. Kept in a file: after Ctrl-C the same script goes on where it was.
diagram = valve.diagram(
    q=(0.0201, 0.0215, 300), observe="y2", start="carry", chunk=16, transient=200, keep=60,
    out="valve_study.npz", progress=True,
)  # fmt: skip
print(diagram)
settled = np.unique(diagram["outcome"], return_counts=True)
print(dict(zip(*(values.tolist() for values in settled))))

# One impact less in a period from window to window.
periodic = diagram["period"] == 1
print("impacts a period in windows of period one:", np.unique(diagram["impacts_per_return"][periodic]))

# Any orbit can be followed from where it started in the diagram.
first = diagram.orbit(int(np.argmax(periodic)))
print(first, first.model.simulate(stop="section:closing=3").counts)

axes = diagram.plot(shear="auto")
axes.axvline(border.value, color="tab:red", linewidth=0.8)
axes.figure.savefig("valve_study.png", dpi=150)
