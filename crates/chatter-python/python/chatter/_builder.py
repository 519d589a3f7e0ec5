"""Models from Python: expressions with operators, which become the text of a model file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, Union

from chatter._errors import InputError
from chatter._model import Model
from chatter._text import name_of, text_of

_SUM, _PRODUCT, _SIGN, _POWER, _ATOM = range(5)


class Expr:
    """An expression of the model language.

    Made by `expr` and `ModelBuilder`, combined with `+ - * / ** %`, comparisons and the functions of this module.
    """

    __slots__ = ("_text", "_level")
    # Arrays are to leave the operators to us.
    __array_ufunc__ = None

    def __init__(self, text: str, level: int = _ATOM) -> None:
        self._text = text
        self._level = level

    def _chatter_text_(self) -> str:
        return self._text

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"Expr({self._text!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return (Expr, (self._text, self._level))

    def __bool__(self) -> bool:
        raise TypeError("an expression is neither true nor false; if_(condition, a, b) chooses between two")

    def _at(self, level: int) -> str:
        return self._text if self._level >= level else f"({self._text})"

    def __add__(self, other: Operand) -> Expr:
        return _joined(self, "+", other, _SUM)

    def __radd__(self, other: Operand) -> Expr:
        return _joined(other, "+", self, _SUM)

    def __sub__(self, other: Operand) -> Expr:
        return _joined(self, "-", other, _SUM)

    def __rsub__(self, other: Operand) -> Expr:
        return _joined(other, "-", self, _SUM)

    def __mul__(self, other: Operand) -> Expr:
        return _joined(self, "*", other, _PRODUCT)

    def __rmul__(self, other: Operand) -> Expr:
        return _joined(other, "*", self, _PRODUCT)

    def __truediv__(self, other: Operand) -> Expr:
        return _joined(self, "/", other, _PRODUCT)

    def __rtruediv__(self, other: Operand) -> Expr:
        return _joined(other, "/", self, _PRODUCT)

    def __mod__(self, other: Operand) -> Expr:
        return _call("mod", self, other)

    def __rmod__(self, other: Operand) -> Expr:
        return _call("mod", other, self)

    def __pow__(self, other: Operand) -> Expr:
        return Expr(f"{self._at(_ATOM)}^{_expr(other)._at(_ATOM)}", _POWER)

    def __rpow__(self, other: Operand) -> Expr:
        return Expr(f"{_expr(other)._at(_ATOM)}^{self._at(_ATOM)}", _POWER)

    def __neg__(self) -> Expr:
        return Expr(f"-{self._at(_POWER)}", _SIGN)

    def __pos__(self) -> Expr:
        return self

    def __abs__(self) -> Expr:
        return _call("abs", self)

    def __lt__(self, other: Operand) -> Condition:
        return Condition(f"{self._text} < {_expr(other)}")

    def __le__(self, other: Operand) -> Condition:
        return Condition(f"{self._text} <= {_expr(other)}")

    def __gt__(self, other: Operand) -> Condition:
        return Condition(f"{self._text} > {_expr(other)}")

    def __ge__(self, other: Operand) -> Condition:
        return Condition(f"{self._text} >= {_expr(other)}")


Operand = Union[Expr, int, float, str, Any]
"""What an expression is combined with: another, a number, a text of the model language, a SymPy expression."""


class Condition:
    """What `if_` asks; combined with `&`, `|` and `~`."""

    __slots__ = ("_text",)

    def __init__(self, text: str) -> None:
        self._text = text

    def _chatter_text_(self) -> str:
        return self._text

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"Condition({self._text!r})"

    def __bool__(self) -> bool:
        raise TypeError("a condition is neither true nor false before the model runs; combine conditions with & | ~")

    def __and__(self, other: Condition) -> Condition:
        return Condition(f"({self._text}) and ({other._text})")

    def __or__(self, other: Condition) -> Condition:
        return Condition(f"({self._text}) or ({other._text})")

    def __invert__(self) -> Condition:
        return Condition(f"not ({self._text})")


def expr(value: Operand) -> Expr:
    """An expression from a text of the model language, a number or a SymPy expression."""
    return _expr(value)


def _expr(value: Operand) -> Expr:
    if isinstance(value, Expr):
        return value
    text = text_of(value)
    # A text may be anything; numbers and names stand by themselves.
    simple = text.replace("_", "").replace(".", "").isalnum()
    return Expr(text, _ATOM if simple else _SUM)


def _joined(left: Operand, sign: str, right: Operand, level: int) -> Expr:
    space = " " if level == _SUM else ""
    # What stands on the right is grouped as Python has it: 1 - (2 - 3).
    text = f"{_expr(left)._at(level)}{space}{sign}{space}{_expr(right)._at(level + 1)}"
    return Expr(text, level)


def _call(name: str, *arguments: Operand) -> Expr:
    return Expr(f"{name}(" + ", ".join(text_of(argument) for argument in arguments) + ")")


pi = Expr("pi")
"""The circle constant."""
time = Expr("t")
"""The time."""


def sin(x: Operand) -> Expr:
    """The sine."""
    return _call("sin", x)


def cos(x: Operand) -> Expr:
    """The cosine."""
    return _call("cos", x)


def tan(x: Operand) -> Expr:
    """The tangent."""
    return _call("tan", x)


def asin(x: Operand) -> Expr:
    """The inverse of the sine."""
    return _call("asin", x)


def acos(x: Operand) -> Expr:
    """The inverse of the cosine."""
    return _call("acos", x)


def atan(x: Operand) -> Expr:
    """The inverse of the tangent."""
    return _call("atan", x)


def atan2(y: Operand, x: Operand) -> Expr:
    """The angle of the point (x, y)."""
    return _call("atan2", y, x)


def sinh(x: Operand) -> Expr:
    """The hyperbolic sine."""
    return _call("sinh", x)


def cosh(x: Operand) -> Expr:
    """The hyperbolic cosine."""
    return _call("cosh", x)


def tanh(x: Operand) -> Expr:
    """The hyperbolic tangent."""
    return _call("tanh", x)


def exp(x: Operand) -> Expr:
    """The exponential."""
    return _call("exp", x)


def log(x: Operand) -> Expr:
    """The natural logarithm."""
    return _call("log", x)


def sqrt(x: Operand) -> Expr:
    """The square root."""
    return _call("sqrt", x)


def abs_(x: Operand) -> Expr:
    """The absolute value; so is Python's own `abs`."""
    return _call("abs", x)


def sign(x: Operand) -> Expr:
    """1 where x is positive, -1 where it is negative; where it is zero a field that jumps is crossed or slid along."""
    return _call("sign", x)


def step(x: Operand) -> Expr:
    """1 where x is positive, 0 where it is negative."""
    return _call("step", x)


def floor(x: Operand) -> Expr:
    """The greatest whole number that is not above x."""
    return _call("floor", x)


def mod(x: Operand, y: Operand) -> Expr:
    """What is left of x after whole multiples of y."""
    return _call("mod", x, y)


def min_(*values: Operand) -> Expr:
    """The least of values."""
    return _call("min", *values)


def max_(*values: Operand) -> Expr:
    """The greatest of values."""
    return _call("max", *values)


def clamp(x: Operand, low: Operand, high: Operand) -> Expr:
    """x, or the bound that it is beyond."""
    return _call("clamp", x, low, high)


def if_(condition: Condition | str, then: Operand, otherwise: Operand) -> Expr:
    """`then` where the condition holds, else `otherwise`."""
    return _call("if", condition, then, otherwise)


Label = Union[str, tuple[str, str], None]
"""What figures call a state or parameter: a text, or a text and a unit."""


class ModelBuilder:
    """Puts a model together.

        b = ch.ModelBuilder("Bouncing ball")
        g, r = b.parameter("g", 9.81), b.parameter("r", 0.5)
        y, v = b.state("y", 1), b.state("v", 0)
        b.flow(y, v)
        b.flow(v, -g)
        b.contact("floor", gap=y, impulse={v: 1}, restitution=r)
        ball = b.build()

    Expressions are `Expr`, numbers, texts of the model language, or SymPy's. `text()` is the model file that comes of it.
    """

    def __init__(self, title: str | None = None, source: str | None = None) -> None:
        self._top: dict[str, Any] = {}
        if title is not None:
            self._top["title"] = title
        if source is not None:
            self._top["source"] = source
        self._parameters: dict[str, str] = {}
        self._definitions: dict[str, str] = {}
        self._flight: dict[str, str] = {}
        self._initial: dict[str, str] = {}
        self._labels: dict[str, Any] = {}
        self._tables: dict[str, dict[str, Any]] = {}
        self._contacts: list[dict[str, Any]] = []
        self._events: list[dict[str, Any]] = []
        self._sections: dict[str, dict[str, Any]] = {}

    def simultaneous(self, law: str) -> None:
        """How contacts that touch at one instant collide: "binary", or "moreau"."""
        self._top["simultaneous"] = law

    def parameter(self, name: Any, value: Operand, label: Label = None) -> Expr:
        """A parameter; its value is a number or an expression in other parameters."""
        return self._named(self._parameters, name, value, label)

    def define(self, name: Any, value: Operand) -> Expr:
        """A name for a part of expressions."""
        return self._named(self._definitions, name, value, None)

    def state(self, name: Any, initial: Operand = 0.0, label: Label = None) -> Expr:
        """A state and where it starts; `flow` says how it changes."""
        return self._named(self._initial, name, initial, label)

    def initial_time(self, value: Operand) -> None:
        """The time at which trajectories start, of equations that depend on it."""
        self._initial["t"] = text_of(value)

    def _named(self, where: dict[str, str], name: Any, value: Operand, label: Label) -> Expr:
        name = name_of(name)
        if any(name in known for known in (self._parameters, self._definitions, self._initial)):
            raise InputError(f"`{name}` is there already")
        where[name] = text_of(value)
        if isinstance(label, str):
            self._labels[name] = label
        elif label is not None:
            self._labels[name] = {"text": label[0], "unit": label[1]}
        return Expr(name)

    def flow(self, state: Any, derivative: Operand) -> None:
        """The derivative of a state with respect to time, in free flight."""
        name = name_of(state)
        if name not in self._initial:
            raise InputError(f"there is no state `{name}`: make it first, with state(\"{name}\", initial)")
        self._flight[name] = text_of(derivative)

    def contact(
        self,
        name: Any,
        *,
        gap: Operand,
        impulse: Mapping[Any, Operand] | None = None,
        restitution: Operand | None = None,
        reset: Mapping[Any, Operand] | None = None,
        friction: Mapping[str, Any] | None = None,
    ) -> None:
        """A contact: a gap that is never negative, with impulse and restitution, or with the state after an impact."""
        self._contacts.append(_entries(
            name=name_of(name), gap=gap, impulse=impulse, restitution=restitution, reset=reset, friction=friction,
        ))  # fmt: skip

    def event(
        self, name: Any, surface: Operand, reset: Mapping[Any, Operand], direction: str = "either"
    ) -> None:
        """A change of the state where a function crosses zero: "rising", "falling" or "either" way."""
        self._events.append(_entries(name=name_of(name), surface=surface, direction=direction, reset=reset))

    def section(self, name: Any, surface: Operand, direction: str = "either") -> None:
        """Where to look: a surface that is crossed "rising", "falling" or "either" way."""
        self._sections[name_of(name)] = _entries(surface=surface, direction=direction)

    def table(
        self, name: Any, x: Sequence[float], y: Sequence[float], kind: str = "linear", **more: Any
    ) -> Any:
        """A function through points, which is called in expressions; gives it as a Python function."""
        name = name_of(name)
        points = {"x": [float(v) for v in x], "y": [float(v) for v in y]}
        self._tables[name] = {**points, "kind": kind, **more}
        return lambda argument: _call(name, argument)

    def text(self) -> str:
        """The model file."""
        missing = [name for name in self._initial if name not in self._flight and name != "t"]
        if missing:
            raise InputError(f"nothing says how `{missing[0]}` changes: give flow({missing[0]}, ...)")
        lines = [f"{key} = {_toml(value)}" for key, value in self._top.items()]
        # In the order of the flow, where states have theirs.
        for title, entries in [
            ("parameters", self._parameters), ("definitions", self._definitions),
            ("flight", {name: self._flight[name] for name in self._initial if name != "t"}),
        ]:  # fmt: skip
            lines += _table(title, entries)
        for name, table in self._tables.items():
            lines += _table(f"table.{name}", table)
        for kind, entries_of in [("contact", self._contacts), ("event", self._events)]:
            for entry in entries_of:
                lines += ["", f"[[{kind}]]", *(f"{key} = {_toml(value)}" for key, value in entry.items())]
        for name, section in self._sections.items():
            lines += _table(f"section.{name}", section)
        lines += _table("initial", self._initial)
        lines += _table("labels", self._labels)
        return "\n".join(lines).lstrip("\n") + "\n"

    def build(self) -> Model:
        """The model.

        Raises ModelError with everything that is wrong with it.
        """
        return Model(self.text(), name=str(self._top.get("title", "model")))


def _entries(**given: Any) -> dict[str, Any]:
    """What was given, its expressions as texts."""
    entries: dict[str, Any] = {}
    for key, value in given.items():
        if isinstance(value, Mapping):
            entries[key] = {_key(name): _value(one) for name, one in value.items()}
        elif value is not None:
            entries[key] = text_of(value)
    return entries


def _key(name: Any) -> str:
    return name_of(name)


def _value(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {_key(name): _value(one) for name, one in value.items()}
    return text_of(value)


def _table(title: str, entries: Mapping[str, Any]) -> list[str]:
    if not entries:
        return []
    return ["", f"[{title}]", *(f"{key} = {_toml(value)}" for key, value in entries.items())]


def _toml(value: Any) -> str:
    if isinstance(value, str):
        # Strings of JSON are strings of TOML, but for one character that JSON lets stand.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value)
