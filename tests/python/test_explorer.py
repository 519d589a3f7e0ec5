"""The explorer's widget, as a notebook's page would speak with it."""

from __future__ import annotations

import json
import struct
import threading
from collections.abc import Iterator
from typing import Any

import chatter as ch
import numpy as np
import pytest
from chatter import _explorer

END, DOCUMENT, NUMBERS, REFUSAL = 0, 1, 3, 7


def records(stream: bytes) -> Iterator[tuple[int, bytes]]:
    while stream:
        length, kind = struct.unpack("<II", stream[:8])
        yield kind, stream[8 : 8 + length]
        stream = stream[8 + length :]


@pytest.fixture
def widget(monkeypatch: pytest.MonkeyPatch) -> Any:
    widget = ch.explore(ch.Model.shipped("bouncing_ball").with_values(r=0.6))
    widget.heard = b""
    widget.ended = threading.Event()

    def send(content: dict[str, Any], buffers: list[bytes]) -> None:
        assert content == {"number": 1}
        widget.heard += buffers[0]
        if any(kind == END for kind, _ in records(widget.heard)):
            widget.ended.set()

    monkeypatch.setattr(widget, "send", send)
    return widget


def asked(widget: Any, topic: str, question: dict[str, Any]) -> list[tuple[int, bytes]]:
    widget._heard(widget, {"number": 1, "asked": topic, "question": question}, [])
    assert widget.ended.wait(60)
    return list(records(widget.heard))


def question_model() -> dict[str, Any]:
    text = ch.shipped_models()["bouncing_ball"]
    return {"name": "bouncing_ball", "text": text, "set": [["r", "0.6"]], "initial": []}


def test_a_motion_is_that_of_simulate(widget: Any) -> None:
    told = asked(widget, "history", {"model": question_model(), "until": "1"})
    about = json.loads(next(content for kind, content in told if kind == DOCUMENT))
    run = ch.Model.shipped("bouncing_ball").with_values(r=0.6).simulate(1)
    # Where a motion stops to be looked at moves its end by a rounding.
    assert np.allclose(about["state"], run.y[:, -1], rtol=1e-14, atol=0)
    columns = [np.frombuffer(content) for kind, content in told if kind == NUMBERS]
    assert len(columns) >= 3
    assert columns[0][0] == 0


def test_what_is_wrong_is_refused(widget: Any) -> None:
    told = asked(widget, "check", {"model": {"name": "m", "text": "nonsense"}})
    refusal = json.loads(next(content for kind, content in told if kind == REFUSAL))
    assert refusal["kind"] == "model"
    assert told[-1][0] == END


def test_a_question_can_be_stopped(widget: Any) -> None:
    model = ch.shipped_models()["impact_oscillator"]
    question = {"model": {"name": "m", "text": model}, "runs": [["omega=2.5:3:1000"]], "observe": ["x"], "transient": 10_000_000}
    widget._heard(widget, {"number": 1, "asked": "diagram", "question": question}, [])
    assert not widget.ended.wait(0.3)
    widget._heard(widget, {"number": 1, "stop": True}, [])
    assert widget.ended.wait(60)


def test_the_page_begins_with_the_values_of_the_model(widget: Any) -> None:
    assert widget.address == "#model=bouncing_ball&set=r%3D0.6"


def test_all_modules_of_the_page_are_there() -> None:
    script, style = _explorer.front_end()
    assert '"widget.js"' in script
    assert ".chatter-explorer" in style
    # It does not restyle the notebook.
    assert "\nbody" not in style
