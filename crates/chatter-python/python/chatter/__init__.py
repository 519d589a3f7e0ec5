"""Mechanical systems with impacts: trajectories through flights, impacts, chatter, contact and release.

    import chatter as ch
    valve = ch.Model.shipped("pressure_relief_valve").with_values(q=0.0195)
    run = valve.simulate(40, stop="accumulation:seat=10")
    run.t, run.y, run["y1"], run.events["release"].time

Units are those of the model. Results are frozen and can be pickled. pandas, xarray and matplotlib are imported only where
they are asked for.
"""

from __future__ import annotations

# What type checkers take for true; importing `typing` would take longer than all else here.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from chatter._border import Border, Borders
    from chatter._branches import branches
    from chatter._builder import (
        Expr, ModelBuilder, abs_, acos, asin, atan, atan2, clamp, cos, cosh, exp, expr, floor, if_, log, max_, min_, mod, pi,
        sign, sin, sinh, sqrt, step, tan, tanh, time,
    )
    from chatter._chatter import __version__
    from chatter._diagram import Diagram, Orbit
    from chatter._errors import (
        ChatterError, ChatterWarning, InputError, ModelError, ModelIssue, OutputError, RunError, UnfinishedError,
    )
    from chatter._explorer import explore
    from chatter._journals import merge, resume
    from chatter._model import Model, shipped_models
    from chatter._periodic import Arc, Branch, Curve, Exponents, PeriodicOrbit, Special
    from chatter._run import ContactPhases, Events, Run
    from chatter._universal import Universal

__all__ = [
    "Arc", "Border", "Borders", "Branch", "ChatterError", "ChatterWarning", "ContactPhases", "Curve", "Diagram", "Events", "Exponents",
    "Expr", "InputError", "Model", "ModelBuilder", "ModelError", "ModelIssue", "Orbit", "OutputError", "PeriodicOrbit", "Run",
    "RunError", "Special", "UnfinishedError", "Universal", "__version__", "abs_", "acos", "asin", "atan", "atan2", "branches",
    "clamp", "cos", "cosh", "exp", "explore", "expr", "floor",
    "if_", "log", "max_", "merge", "min_", "mod", "pi", "resume", "shipped_models", "sign", "sin", "sinh", "sqrt", "step", "tan",
    "tanh", "time",
]

_HOMES = {
    "_border": "Border Borders",
    "_branches": "branches",
    "_builder": "Expr ModelBuilder abs_ acos asin atan atan2 clamp cos cosh exp expr floor if_ log max_ min_ mod pi sign sin sinh "
    "sqrt step tan tanh time",
    "_chatter": "__version__",
    "_diagram": "Diagram Orbit",
    "_errors": "ChatterError ChatterWarning InputError ModelError ModelIssue OutputError RunError UnfinishedError",
    "_explorer": "explore",
    "_journals": "merge resume",
    "_model": "Model shipped_models",
    "_periodic": "Arc Branch Curve Exponents PeriodicOrbit Special",
    "_run": "ContactPhases Events Run",
    "_universal": "Universal",
}


def __getattr__(name: str) -> Any:
    # Modules are imported when something of them is asked for: the command, which needs none, does not wait for NumPy.
    for home, names in _HOMES.items():
        if name in names.split():
            from importlib import import_module

            value = getattr(import_module(f"chatter.{home}"), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module 'chatter' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
