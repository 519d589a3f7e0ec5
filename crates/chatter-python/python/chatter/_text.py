"""Numbers and expressions as text of the model language."""

from __future__ import annotations

import math
import numbers
import re
from typing import Any

from chatter._errors import InputError


def text_of(value: Any) -> str:
    """The text of a number, a text, an `Expr` or a SymPy expression, to the last bit.

    Doubles are written with the shortest digits that give them back.
    """
    if isinstance(value, str):
        return value
    told = getattr(value, "_chatter_text_", None)
    if told is not None:
        return str(told())
    if isinstance(value, bool):
        raise InputError(f"{value} is no number: expected a number or an expression")
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        number = float(value)
        if not math.isfinite(number):
            raise InputError(f"{number} is not finite: expected a number or an expression")
        return repr(number)
    if hasattr(value, "free_symbols") and hasattr(value, "func"):
        return _of_sympy(value)
    # Arrays without dimensions, and what else can say that it is one number.
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        return text_of(value.item())
    raise InputError(f"{value!r} is neither a number nor an expression")


def name_of(value: Any) -> str:
    """The name that a text, an `Expr` or a SymPy symbol is."""
    text = text_of(value)
    if re.fullmatch(r"[A-Za-z_]\w*", text) is None:
        raise InputError(f"`{text}` is no name")
    return text


_SYMPY_CALLS = {
    "Abs": "abs", "sign": "sign", "floor": "floor", "Min": "min", "Max": "max", "Mod": "mod", "atan2": "atan2",
    "sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "acos": "acos", "atan": "atan",
    "sinh": "sinh", "cosh": "cosh", "tanh": "tanh", "exp": "exp", "log": "log",
}  # fmt: skip


def _of_sympy(value: Any) -> str:
    """A SymPy expression, written out operation by operation."""
    import sympy

    if isinstance(value, (sympy.Symbol, sympy.core.function.AppliedUndef)):
        # A function of time, such as x(t), is the state of its name.
        return name_of(str(value.func) if value.args else value.name)
    if value is sympy.pi:
        return "pi"
    if value is sympy.E:
        return "exp(1)"
    if isinstance(value, sympy.Integer):
        return f"({value})" if value < 0 else str(value)
    if isinstance(value, sympy.Rational):
        return f"({value.p}/{value.q})"
    if isinstance(value, sympy.Float):
        # Beyond double precision its own digits are meant.
        text = repr(float(value)) if value._prec <= 53 else str(value)
        return f"({text})" if value < 0 else text
    if isinstance(value, sympy.Add):
        return "(" + " + ".join(_of_sympy(term) for term in value.args) + ")"
    if isinstance(value, sympy.Mul):
        return "(" + "*".join(_of_sympy(factor) for factor in value.args) + ")"
    if isinstance(value, sympy.Pow):
        base, exponent = value.args
        if exponent == sympy.Rational(1, 2):
            return f"sqrt({_of_sympy(base)})"
        if exponent == -1:
            return f"(1/{_of_sympy(base)})"
        return f"({_of_sympy(base)}^{_of_sympy(exponent)})"
    if isinstance(value, sympy.Piecewise):
        return _of_piecewise(value)
    if isinstance(value, sympy.core.relational.Relational):
        if value.rel_op not in ("<", "<=", ">", ">="):
            raise InputError(f"`{value}` is no condition: expected one with <, <=, > or >=")
        return f"{_of_sympy(value.lhs)} {value.rel_op} {_of_sympy(value.rhs)}"
    if isinstance(value, (sympy.And, sympy.Or)):
        joint = " and " if isinstance(value, sympy.And) else " or "
        return "(" + joint.join(f"({_of_sympy(part)})" for part in value.args) + ")"
    if isinstance(value, sympy.Not):
        return f"(not ({_of_sympy(value.args[0])}))"
    name = _SYMPY_CALLS.get(type(value).__name__)
    if name is None:
        raise InputError(f"the model language has no `{type(value).__name__}`, which stands in `{value}`")
    return f"{name}(" + ", ".join(_of_sympy(argument) for argument in value.args) + ")"


def _of_piecewise(value: Any) -> str:
    *pieces, (last, condition) = value.args
    if condition not in (True, 1) and str(condition) != "True":
        raise InputError(f"`{value}` has no value elsewhere: end it with (value, True)")
    text = _of_sympy(last)
    for piece, condition in reversed(pieces):
        text = f"if({_of_sympy(condition)}, {_of_sympy(piece)}, {text})"
    return text


def labelled(name: str, label: tuple[str | None, str | None] | None) -> str:
    """What an axis is called, with its unit."""
    text, unit = label or (None, None)
    return (text or name) + (f" ({unit})" if unit else "")
