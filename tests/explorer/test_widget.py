"""The same page as a widget, in a page that stands in for a notebook's."""

from __future__ import annotations

import base64
import json
import struct
import threading

import pytest
from conftest import until
from playwright.sync_api import Browser

ch = pytest.importorskip("chatter", reason="the Python package is built by .ci/package")

# What anywidget gives a widget, with the kernel in Python's place.
NOTEBOOK = """async ([script, address]) => {
    const widget = (await import(URL.createObjectURL(new Blob([script], { type: "text/javascript" })))).default;
    const listeners = new Map();
    const state = { address };
    const model = {
        get: (name) => state[name],
        set: (name, value) => { state[name] = value; },
        save_changes: () => { window.saved = state.address; },
        on: (event, listener) => listeners.set(event, (listeners.get(event) ?? new Set()).add(listener)),
        off: (event, listener) => listeners.get(event)?.delete(listener),
        send: async ({ number, asked, question, stop }) => {
            if (stop) return;
            const bytes = Uint8Array.from(atob(await window.kernel(asked, JSON.stringify(question))), (letter) => letter.charCodeAt(0));
            for (const listener of [...(listeners.get("msg:custom") ?? [])]) listener({ number }, [new DataView(bytes.buffer)]);
        },
    };
    await widget.render({ model, el: document.body });
}"""


def has_ended(stream: bytes) -> bool:
    """Whether the last record is there: that of kind zero."""
    place = 0
    while place < len(stream):
        length, kind = struct.unpack_from("<II", stream, place)
        if kind == 0:
            return True
        place += 8 + length
    return False


def test_the_widget_shows_what_the_page_shows(browser: Browser) -> None:
    from chatter import _chatter, _explorer

    model = ch.Model.shipped("bouncing_ball").with_values(r=0.6)
    script, _ = _explorer.front_end()

    def kernel(asked: str, question: str) -> str:
        heard = b""
        ended = threading.Event()

        def put(records: bytes) -> None:
            nonlocal heard
            heard += records
            if has_ended(heard):
                ended.set()

        _chatter.explorer_answer(model._core, asked, question.encode(), put)
        assert ended.wait(60)
        return base64.b64encode(heard).decode()

    page = browser.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.expose_function("kernel", kernel)
    page.set_content("<p>a notebook</p>")
    page.evaluate(NOTEBOOK, [script, _explorer.address_of(model)])
    found = "document.querySelector('#history canvas')?.dataset.end"
    until(lambda: page.evaluate(found), "the motion")
    about = json.loads(page.evaluate(found))
    time = float(page.evaluate("document.querySelector('#history canvas').dataset.time"))
    run = model.simulate(time)
    assert about == pytest.approx(list(run.y[:, -1]), abs=1e-12)
    until(lambda: page.evaluate("window.saved"), "the address")
    assert "r%3D0.6" in page.evaluate("window.saved")
    assert faults == []
