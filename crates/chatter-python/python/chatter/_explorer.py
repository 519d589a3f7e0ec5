"""The explorer as a widget for notebooks: the same page as `chatter explore`, asking this process."""

from __future__ import annotations

import json
import urllib.parse
from typing import TYPE_CHECKING, Any

from chatter import _chatter
from chatter._errors import InputError

if TYPE_CHECKING:
    from chatter._model import Model

# Modules of the page name each other as files; in a notebook they are texts.
_LOADER = """
const sources = %s;
const places = {};
function place(name) {
    if (!(name in places)) {
        const beside = (other) => new URL(other, "file:///" + name).pathname.slice(1);
        const text = sources[name].replace(/from "(\\.[\\w\\/.-]+\\.js)"/g, (_, other) => `from "${place(beside(other))}"`);
        places[name] = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
    }
    return places[name];
}
export default (await import(place("widget.js"))).default;
"""


def front_end() -> tuple[str, str]:
    """The script and the style of the widget."""
    page = dict(_chatter.explorer_page())
    modules = {name: text for name, text in page.items() if name.endswith(".js") and name != "main.js"}
    return _LOADER % json.dumps(modules), page["style.css"]


def address_of(model: Model) -> str:
    """What the page begins with: the model, with what was set into it."""
    core = model._core
    pairs = [("model", core.name)]
    pairs += [("set", f"{name}={value}") for name, value in core.set]
    pairs += [("initial", f"{name}={value}") for name, value in core.initial]
    return "#" + urllib.parse.urlencode(pairs)


def explore(model: Model | None = None) -> Any:
    """The explorer of a model as a widget, for Jupyter, marimo and whatever else shows anywidgets.

    model: the pressure relief valve without one. Its values are those that the page begins with. The widget's `address` is what
    is looked at, as text: give it to another widget, and it shows the same.
    """
    try:
        import anywidget
        import traitlets
    except ImportError as error:
        raise InputError("explore needs anywidget: pip install anywidget") from error
    if model is None:
        from chatter._model import Model as Equations

        model = Equations.shipped("pressure_relief_valve")
    core = model._core
    script, style = front_end()

    class Explorer(anywidget.AnyWidget):  # type: ignore[misc, unused-ignore]
        """The page, and the questions that it has asked."""

        _esm = script
        _css = style
        address = traitlets.Unicode("").tag(sync=True)

        def __init__(self, **more: Any) -> None:
            super().__init__(**more)
            self._open: dict[int, _chatter.Question] = {}
            self.on_msg(self._heard)

        def _heard(self, _: Any, content: dict[str, Any], __: Any) -> None:
            number = content["number"]
            if content.get("stop"):
                question = self._open.pop(number, None)
                if question is not None:
                    question.stop()
                return

            def put(records: bytes) -> None:
                self.send({"number": number}, buffers=[records])

            body = json.dumps(content["question"]).encode()
            self._open[number] = _chatter.explorer_answer(core, content["asked"], body, put)

    return Explorer(address=address_of(model))
