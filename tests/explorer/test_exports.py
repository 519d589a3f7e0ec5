"""What views give: files, command lines and lines of Python, each carried out and compared with the page."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BINARY, Explorer, View, until, viewed
from playwright.sync_api import Browser, Download

VALVE = "#model=pressure_relief_valve&over=q=0.0202:0.0203&observe=y2&sampling=section:closing&columns=128&transient=30&keep=12"
PLAIN = VALVE + "&time=0:12&at=0.0203&returned=y2&portrait=y1,y3"


def branches(view: View) -> None:
    view.page.get_by_role("button", name="Periodic orbits").click()
    until(lambda: "orbits on" in (view.page.locator(".overlay .status").text_content() or ""), "the branch")


def curve(view: View) -> None:
    branches(view)
    view.page.locator(".special button", has_text="fold at").first.click()
    until(lambda: "on the curve" in (view.page.locator(".overlay .status").text_content() or ""), "the curve")


def border(view: View) -> None:
    view.page.get_by_role("button", name="Chatter borders").click()
    until(lambda: "1 border orbit" in (view.page.locator(".overlay .status").text_content() or ""), "the border")


def universal(view: View) -> None:
    border(view)
    view.page.locator("#returns select").first.select_option("Υ(K z + μ)")
    until(lambda: view.data("returns").get("curve"), "the curve")


def later(view: View) -> None:
    slider = view.page.locator("#mechanism input[aria-label=Time]")
    slider.evaluate("(slider) => { slider.value = 3.3; slider.dispatchEvent(new Event('input')); }")


def curved(view: View) -> None:
    until(lambda: view.data("returns").get("curve"), "the curve")


BALL = "#model=bouncing_ball&over=r=0.5:0.9&set=r=0.7&observe=y&sampling=section:apex&columns=64&time=0.5:2&at=0.7&returned=y"
# Of a map.
COARSE = PLAIN.replace("columns=128", "columns=48")
BORDER = PLAIN.replace("0.0202:0.0203", "0.02:0.0236").replace("at=0.0203", "at=0.0222")
# Where it is, the menu, what is done before, and the stem of the files of the command line.
VIEWS: dict[str, tuple[str, str, Callable[[View], None] | None, str]] = {
    "diagram": (PLAIN, "#diagram > header .gifts", None, "diagram"),
    "map": (COARSE + "&second=kappa=1.2:1.3", "#diagram > header .gifts", None, "diagram"),
    "history": (PLAIN, "#history .gifts", None, "history"),
    "portrait": (PLAIN, "#portrait .gifts", None, "portrait"),
    "returns": (PLAIN.replace("0:12", "0:30"), "#returns .gifts", None, "returns"),
    "returns on a curve": (BALL, "#returns .gifts", curved, "returns"),
    "impacts": (PLAIN, "#impacts .gifts", None, "impacts"),
    "mechanism": (PLAIN, "#mechanism .gifts", later, "mechanism"),
    "branches": (PLAIN, "summary[aria-label^='Export of branches']", branches, "branches"),
    "curve": (COARSE + "&second=kappa=1.2495:1.2505", "summary[aria-label^='Export of curve']", curve, "curve"),
    "border": (BORDER, "summary[aria-label^='Export of border']", border, "border"),
    "universal": (BORDER, "#returns .gifts", universal, "cobweb"),
}


# Views of which the data are two tables.
TWO = ("returns on a curve",)
# Views that are computed anew, for seconds, with each file.
LONG = ("branches", "curve", "border")
# Views of a motion.
MOTION = ("#history", "#portrait", "#returns", "#impacts", "#mechanism")


def filled(lines: list[str]) -> list[str] | None:
    return lines if all(lines) else None


class Menu:
    """What a view gives."""

    def __init__(self, view: View, name: str) -> None:
        where, at, before, self.stem = VIEWS[name]
        self.name = name
        self.view, self.page = view, view.open(where).page
        view.complete()
        view.motion()
        if before:
            before(view)
        found = self.page.locator(at)
        self.menu = found if at.endswith(".gifts") else found.locator("xpath=..")
        self.menu.locator("summary").click()
        # An opened menu is filled in a moment later: "toggle" is told in its turn.
        lines: list[str] = until(lambda: filled(self.menu.locator("code").all_text_contents()), "the lines of the menu")
        self.command, self.python = lines
        self.saved: dict[str, list[Download]] = {}

    def file(self, kind: str, path: Path) -> Path:
        """What is saved, the first one where there are several. It is asked for once."""
        if kind not in self.saved:
            self.saved[kind] = self.save(kind)
        for number, one in enumerate(self.saved[kind]):
            one.save_as(path / f"ours{number or ''}.{kind}")
        return path / f"ours.{kind}"

    def save(self, kind: str) -> list[Download]:
        saved: list[Download] = []

        def take(download: Download) -> None:
            saved.append(download)

        self.page.on("download", take)
        self.menu.get_by_role("button", name=kind.upper(), exact=True).click()
        until(lambda: len(saved) >= (2 if self.name in TWO and kind in ("npz", "csv") else 1) or self.page.wait_for_timeout(20), "the file")
        self.page.remove_listener("download", take)
        return saved


# Both tests ask the same page: what it shows takes longer than they do.
@pytest.fixture(params=VIEWS, scope="module")
def menu(request: pytest.FixtureRequest, browser: Browser, explorer: Explorer) -> Iterator[Menu]:
    with viewed(browser, explorer) as view:
        yield Menu(view, request.param)


def test_a_command_line_makes_the_files_of_its_view(menu: Menu, tmp_path: Path) -> None:
    menu.file("npz", tmp_path)
    picture = menu.file("svg", tmp_path)
    if menu.name not in LONG:
        assert menu.file("png", tmp_path).read_bytes().startswith(b"\x89PNG")
        assert menu.file("pdf", tmp_path).read_bytes().startswith(b"%PDF")
        assert b"," in menu.file("csv", tmp_path).read_bytes()
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/chatter").symlink_to(BINARY)
    surroundings = {**os.environ, "PATH": f"{tmp_path}/bin:{os.environ['PATH']}"}
    done = subprocess.run(menu.command, shell=True, cwd=tmp_path, env=surroundings, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{menu.command}\n{done.stderr}"
    for number, table in enumerate([menu.stem, f"{menu.stem}-curve"] if menu.name in TWO else [menu.stem]):
        with np.load(tmp_path / f"ours{number or ''}.npz") as one, np.load(tmp_path / f"{table}.npz") as other:
            assert sorted(one.files) == sorted(other.files)
            assert any(one[name].size > 1 for name in one.files)
            for name in one.files:
                # The command makes table and picture of a motion in one run, which samples it for both.
                if name == "specification" and VIEWS[menu.name][1].startswith(MOTION) and number == 0:
                    continue
                assert np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f"), name
    assert picture.read_bytes() == (tmp_path / f"{menu.stem}.svg").read_bytes()


def test_a_line_of_python_gives_the_numbers_of_its_view(menu: Menu, tmp_path: Path) -> None:
    ch = pytest.importorskip("chatter", reason="the Python package is built by .ci/package")
    pytest.importorskip("matplotlib").use("Agg")
    import matplotlib.pyplot as plt

    plt.close("all")
    names: dict[str, Any] = {"ch": ch}
    exec(menu.python, names)
    which, view = menu.name, menu.view
    with np.load(menu.file("npz", tmp_path)) as ours:
        if which in ("diagram", "map"):
            for name in ("period", "q", *(["y2"] if which == "diagram" else ["kappa"])):
                assert np.array_equal(names["d"][name], ours[name]), name
        elif which in ("history", "portrait", "mechanism"):
            assert list(names["run"].end.values()) == json.loads(view.data("history")["end"])
            assert len(names["run"].t) == len(ours["y1"])
            if which == "mechanism":
                # The plug, at forty times its lift.
                lift = 40 * names["run"](3.3)[0]
                plug = next(line.get_ydata() for line in plt.gca().lines if line.get_label() == "_mass")
                assert [min(plug), max(plug)] == pytest.approx([lift, lift + 0.4], abs=1e-12)
        elif which == "returns on a curve":
            assert names["x"] == pytest.approx(json.loads(view.data("returns")["points"]), rel=1e-14)
            seen = np.array(json.loads(view.data("returns")["curve"]))
            # From below the floor nothing returns.
            there = seen[[value is not None for _, value in seen]].astype(float)
            assert len(seen) == 400 and 380 < len(there)
            with np.load(tmp_path / "ours1.npz") as curve:
                assert np.array_equal(there, np.transpose([curve["initial_y"][curve["column"]], curve["y"]]))
            drawn = plt.gca().lines[-1]
            assert np.array_equal(np.transpose(drawn.get_data()), there)
        elif which == "returns":
            assert names["x"] == pytest.approx(json.loads(view.data("returns")["points"]), rel=1e-14)
        elif which == "impacts":
            impacts = ours["kind"] == "impact"
            assert np.array_equal(names["e"].rate_before, ours["rate_before"][impacts])
        elif which == "branches":
            assert names["branches"][0]["q"] == pytest.approx(ours["q"], rel=1e-12)
        elif which == "curve":
            assert names["curve"]["kappa"] == pytest.approx(ours["kappa"], rel=1e-9)
        elif which == "border":
            assert names["border"].value == pytest.approx(0.0200560056893, abs=1e-13)
        else:
            assert names["next"] == pytest.approx(ours["curve_next"], rel=1e-7, abs=1e-12)
