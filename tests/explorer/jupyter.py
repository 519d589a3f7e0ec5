"""Shows `ch.explore(...)` in a real page of JupyterLab, and compares the motion there with the library's.

    python tests/explorer/jupyter.py [PICTURE.png]

By hand, for it takes JupyterLab (`pip install jupyterlab`) beside what `.ci/package` and `.ci/browser` install.
"""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path

from playwright.sync_api import sync_playwright

import chatter as ch

CELL = 'import chatter as ch\nch.explore(ch.Model.shipped("bouncing_ball").with_values(r=0.6))'
CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")


def notebook() -> str:
    cell = {"cell_type": "code", "id": "explore", "metadata": {}, "source": CELL, "outputs": [], "execution_count": None}
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    return json.dumps({"cells": [cell], "metadata": kernel, "nbformat": 4, "nbformat_minor": 5})


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def wait_for(address: str) -> None:
    for _ in range(600):
        try:
            urllib.request.urlopen(address).close()
        except (urllib.error.URLError, ConnectionError):
            time.sleep(0.1)
        else:
            return
    raise SystemExit("JupyterLab does not start")


def look(address: str, picture: str | None) -> None:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1600, "height": 1200})
        faults: list[str] = []
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(address)
        page.locator(".jp-Notebook .jp-CodeCell").first.click()
        page.keyboard.press("Shift+Enter")
        canvas = page.locator(".jp-OutputArea #history canvas")
        canvas.wait_for(timeout=120_000)
        page.wait_for_function("document.querySelector('.jp-OutputArea #history canvas').dataset.end", timeout=120_000)
        page.wait_for_function("document.querySelector('.jp-OutputArea #diagram canvas').dataset.state === 'complete'", timeout=120_000)
        end, moment = (canvas.get_attribute(f"data-{name}") or "" for name in ("end", "time"))
        if picture:
            page.screenshot(path=picture)
        run = ch.Model.shipped("bouncing_ball").with_values(r=0.6).simulate(float(moment))
        theirs = list(run.end.values())
        assert all(abs(one - other) < 1e-12 for one, other in zip(json.loads(end), theirs)), (end, theirs)
        assert not [fault for fault in faults if "chatter" in fault], faults
        browser.close()
    print(f"JupyterLab shows the explorer, and the motion of the library: {end} at time {moment}")


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "explore.ipynb").write_text(notebook())
        port = free_port()
        options = ["--no-browser", "--allow-root", f"--port={port}", "--IdentityProvider.token=", f"--ServerApp.root_dir={folder}"]
        server = subprocess.Popen([sys.executable, "-m", "jupyterlab", *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            wait_for(f"http://127.0.0.1:{port}/api/status")
            look(f"http://127.0.0.1:{port}/lab/tree/explore.ipynb", sys.argv[1] if len(sys.argv) > 1 else None)
        finally:
            server.terminate()
            server.wait()


if __name__ == "__main__":
    main()
