"""What theory says over a diagram: curves of special points, border orbits, their windows, and the curves of return maps."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from conftest import View, chatter, until

VALVE = "#model=pressure_relief_valve&observe=y2&sampling=section:closing&transient=30&keep=12&columns=128&time=0:12"
BRANCH = VALVE + "&over=q=0.0202:0.0203"
MAP = BRANCH + "&second=kappa=1.24:1.26"


def status(view: View) -> str:
    return view.page.locator(".overlay .status").text_content() or ""


def overlay(view: View, what: str) -> Any:
    """What lies over the diagram, as the page has it."""
    return view.page.evaluate(f"document.querySelector('#diagram canvas').overlay.{what}")


def test_a_special_point_is_followed_in_two_parameters(view: View, tmp_path: Any) -> None:
    page = view.open(MAP.replace("1.24:1.26", "1.2495:1.2505")).page
    view.complete()
    page.get_by_role("button", name="Periodic orbits").click()
    until(lambda: "orbits on" in status(view), "the branch")
    fold = page.locator(".special button", has_text="fold at").first
    assert fold.get_attribute("aria-pressed") == "false"
    fold.click()
    until(lambda: "points on the curve of fold" in status(view), "the curve")
    assert page.locator(".special button", has_text="fold at").first.get_attribute("aria-pressed") == "true"
    ours = overlay(view, "curves.found[0].curve")
    chatter("continue", "pressure_relief_valve", "--sweep", "q=0.0202:0.0203", "--section", "closing", "--out", "branches.npz", folder=tmp_path)
    with np.load(tmp_path / "branches.npz") as branches:
        number = list(branches["special_kind"]).index("fold") + 1
    told = json.loads(chatter(
        "continue", "pressure_relief_valve", "--sweep", "kappa=1.2495:1.2505", "--section", "closing", "--free", "q,kappa",
        "--from", f"branches.npz:{number}", "--json", folder=tmp_path,
    ))  # fmt: skip
    theirs = told["branches"][0]
    assert ours["kind"] == theirs["kind"] == "fold"
    for name in ("q", "kappa"):
        assert ours["points"][name] == pytest.approx(theirs["points"][name], rel=1e-9)
    # A click forgets it.
    page.locator(".special button", has_text="fold at").first.click()
    until(lambda: overlay(view, "curves.found.length") == 0, "no curve")


def test_a_curve_is_begun_on_the_map_and_given_up(view: View) -> None:
    page = view.open(MAP).page
    view.complete()
    page.get_by_role("button", name="Periodic orbits").click()
    until(lambda: "orbits on" in status(view), "the branch")
    given_up: list[str] = []
    page.on("requestfailed", lambda request: given_up.append(request.url.rsplit("/", 1)[1]))
    x, y = page.evaluate(
        """() => { const { plot, overlay } = document.querySelector("#diagram canvas");
            const { left, top } = plot.canvas.getBoundingClientRect();
            const { point } = overlay.points().find(({ point }) => point.kind === "fold");
            return [left + plot.px(point.value), top + plot.py(overlay.height())]; }"""
    )
    with page.expect_request("**/curve"):
        page.mouse.click(x, y)
    # A second click gives it up, which hangs up.
    page.mouse.click(x, y)
    until(lambda: (status(view), "curve" in given_up)[1], "the end of the request")
    until(lambda: view.explorer.questions() == 0, "the end of the work")
    assert overlay(view, "curves.found.length") == 0


def test_a_border_has_its_windows_beside_it(view: View) -> None:
    page = view.open(VALVE + "&over=q=0.02:0.0236").page
    view.complete()
    page.get_by_role("button", name="Chatter borders").click()
    until(lambda: "1 border orbit" in status(view), "the border")
    told = json.loads(chatter("border", "pressure_relief_valve", "--parameter", "q", "--near", "0.02005", "--json"))
    assert told["value"] == pytest.approx(0.0200560056893, abs=1e-13)
    ours = view.page.evaluate("document.querySelector('#diagram canvas').overlay.border()")
    assert ours["value"] == told["value"]
    assert [window["n"] for window in ours["windows"]] == [window["n"] for window in told["windows"]]
    for one, other in zip(ours["windows"], told["windows"]):
        for end in ("fold", "period_doubling", "grazing"):
            assert one[end] == pytest.approx(other[end], rel=1e-12)
    # Lines stand where they are said to be, from top to bottom, in the colours of the border and of the folds.
    drawn = page.evaluate(
        """(values) => { const { plot } = document.querySelector("#diagram canvas");
            const context = plot.canvas.getContext("2d");
            const { top, height } = plot.area;
            return values.map((value) => [0.3, 0.9].map((part) =>
                [...context.getImageData(Math.round(plot.px(value)) * plot.ratio, (top + part * height) * plot.ratio, 1, 1).data].slice(0, 3))); }""",
        [ours["value"], ours["windows"][-1]["fold"], ours["windows"][-2]["fold"]],
    )
    for color in drawn[0]:
        assert color == pytest.approx([230, 159, 0], abs=60)
    for line in drawn[1:]:
        assert any(color == pytest.approx([0, 158, 115], abs=60) for color in line)


def test_the_universal_map_near_a_border(view: View) -> None:
    page = view.open(VALVE + "&over=q=0.02:0.0236&at=0.0222").page
    view.complete()
    page.get_by_role("button", name="Chatter borders").click()
    until(lambda: "1 border orbit" in status(view), "the border")
    page.locator("#returns select").first.select_option("Υ(K z + μ)")
    until(lambda: view.data("returns").get("curve"), "the curve")
    curve, orbit = (json.loads(view.data("returns")[name]) for name in ("curve", "points"))
    border = json.loads(chatter("border", "pressure_relief_valve", "--parameter", "q", "--near", "0.02005", "--json"))
    slope = border["exact"]["slope"]
    mu = border["exact"]["unfolding_rate"] * (0.0222 - border["value"])
    at = ",".join(repr(slope * z + mu) for z, _ in curve[::100])
    told = json.loads(chatter("universal", "--restitution", "0.8", f"--at={at}", "--json"))
    values = [one["upsilon"] for one in told["values"]]
    # Only where the last bit of x is not that of a fused product does a value near the end of a lap differ by more.
    assert [value for _, value in curve[::100]] == pytest.approx(values, rel=1e-7, abs=1e-12)
    steps = np.interp(orbit[:-1], *np.transpose(curve))
    assert np.median(np.abs(steps - orbit[1:])) < 1e-3 * np.ptp(orbit)


def test_a_return_map_of_one_dimension_has_its_curve(view: View) -> None:
    # A ball falls from a height and rises to r^2 of it.
    page = view.open("#model=bouncing_ball&over=r=0.5:0.9&set=r=0.7&observe=y&sampling=section:apex&time=0:2&returned=y").page
    until(lambda: view.data("returns").get("curve"), "the curve")
    curve = np.array(json.loads(view.data("returns")["curve"]))
    assert len(curve) == 400
    above = curve[curve[:, 0] > 0]
    assert above[:, 1] == pytest.approx(0.49 * above[:, 0], rel=1e-9)
    points = json.loads(view.data("returns")["points"])
    assert len(points) > 3
    # The valve's has two dimensions, and none.
    view.open(VALVE + "&over=q=0.02:0.0236")
    view.motion()
    page.wait_for_timeout(300)
    assert view.data("returns").get("curve", "") == ""


def test_attractors_that_coexist_have_colours_and_shares(view: View) -> None:
    asked: list[Any] = []
    view.page.on("request", lambda request: asked.append(request.post_data_json) if request.url.endswith("/diagram") else None)
    page = view.open("#model=bouncing_ball_on_table&over=Gamma=1.2:1.6&sampling=at:impact&observe=v&columns=128&transient=200&keep=20&start=random:4&box=v=0:1").page
    view.complete()
    assert page.locator("#diagram input[aria-label='Bounds of random starts']").input_value() == "v=0:1"
    # The finest sweep is what the command line makes of it.
    sweep = asked[-1]["runs"][-1][0]
    told = json.loads(chatter(
        "diagram", "bouncing_ball_on_table", "--sweep", sweep, "--start", "random:4", "--box", "v=0:1", "--observe", "v",
        *(part for name in ("section", "at") if name in asked[-1] for part in (f"--{name}", asked[-1][name])),
        "--transient", "200", "--keep", "20", "--json",
    ))  # fmt: skip
    theirs = {one["attractor"]: (one["rows"], one["share"]) for one in told["attractors"]}
    ours = {one["attractor"]: (one["rows"], one["share"]) for one in page.evaluate("document.querySelector('#diagram canvas').rows.attractors")}
    assert len(theirs) >= 2
    assert {number: ours[number] for number in theirs} == theirs
    columns = page.evaluate("document.querySelector('#diagram canvas').rows.in_order().map(({ x, rows }) => [x, rows.map((row) => row.attractor)])")
    count = sum(numbers.count(1) for _, numbers in columns)
    assert count == theirs[1][0]
    legend = page.locator("#diagram .legend .key").all_text_contents()
    assert f"{100 * theirs[1][1]:.1f} %" in legend[0]
    # Both colours are there: blue and vermilion, as in the figures.
    seen = page.evaluate(
        """() => { const { plot } = document.querySelector("#diagram canvas"); const { left, top, width, height } = plot.area;
            const { data } = plot.canvas.getContext("2d").getImageData(left, top, width, height);
            const found = [0, 0];
            for (let at = 0; at < data.length; at += 4) {
                if (data[at] < 90 && data[at + 2] > 140 && data[at + 1] < 170) found[0] += 1;
                if (data[at] > 190 && data[at + 2] < 130) found[1] += 1;
            }
            return found; }"""
    )
    assert min(seen) > 20, seen
