"""What one does on the page, and what it shows then."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import BINARY, View, chatter, until

# A small diagram: what is asked here is what is shown, not how much can be computed.
SMALL = "#model=pressure_relief_valve&over=q=0.0205:0.0225&observe=y2&sampling=section:closing&columns=128&transient=30&keep=12"


def test_an_error_is_underlined_as_it_is_typed(view: View, tmp_path: Path) -> None:
    page = view.open(SMALL).page
    view.complete()
    area = page.locator(".editor textarea")
    wrong = area.input_value().replace("beta*(q - y1*sqrt(y3))", "beta*(q - y1*sqr(y3))")
    area.fill(wrong)
    until(lambda: page.locator(".backdrop .wrong").count(), "an underlined part")
    assert page.locator(".backdrop .wrong").first.text_content() == "sqr"
    told = page.locator(".problem").first.text_content() or ""
    path = tmp_path / "pressure_relief_valve"
    path.write_text(wrong)
    said = chatter("check", str(path))
    message = re.search(r"error: (.*)", said)
    place = re.search(r":(\d+):(\d+)", said)
    assert message and place
    assert message[1] in told
    assert f"line {place[1]}, column {place[2]}" in told
    assert area.get_attribute("aria-invalid") == "true"
    area.fill(wrong.replace("sqr(", "sqrt("))
    until(lambda: page.locator(".backdrop .wrong").count() == 0, "nothing underlined")
    assert area.get_attribute("aria-invalid") == "false"


def test_a_zoom_sharpens_and_keeps_what_is_there(view: View) -> None:
    page = view.open(SMALL).page
    assert int(view.complete()["columns"]) >= 128
    low, high = view.box()
    asked: list[int] = []

    def count(request: object) -> None:
        if request.url.endswith("/diagram"):  # type: ignore[attr-defined]
            runs = request.post_data_json["runs"]  # type: ignore[attr-defined]
            asked.append(sum(int(sweep.rsplit(":", 1)[1]) for [sweep] in runs))

    page.on("request", count)
    page.mouse.move(*view.middle("diagram"))
    page.mouse.wheel(0, -385)
    # Asking the page lets it be heard, too.
    until(lambda: (view.box(), asked)[1], "a question about what is missing")
    columns = int(view.complete()["columns"])
    inner = view.box()
    assert low < inner[0] < inner[1] < high
    assert 0.4 < (inner[1] - inner[0]) / (high - low) < 0.6
    assert columns >= 128
    # Half of them were there.
    assert asked[-1] <= columns * 0.6


def test_a_click_shows_the_motion_of_that_value(view: View) -> None:
    page = view.open(SMALL + "&time=0:12").page
    view.complete()
    before = view.motion()["end"]
    x, y = view.middle("diagram")
    page.mouse.click(x + 111, y)
    motion = view.motion(before)
    value = motion["picked"]
    assert float(value) != 0.0203
    run = json.loads(chatter("simulate", "pressure_relief_valve", "--set", f"q={value}", "--until", "12", "--json"))
    assert json.loads(motion["end"]) == list(run["state"].values())
    assert int(motion["impacts"]) == run["counts"]["impacts"]
    assert float(motion["time"]) == run["time"]


def test_all_views_follow_a_slider(view: View) -> None:
    page = view.open(SMALL + "&time=0:6").page
    before = view.motion()["end"]
    slider = page.locator("#set-kappa")
    box = slider.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    for step in range(8):
        page.mouse.move(box["x"] + box["width"] * (0.5 + 0.02 * step), box["y"] + box["height"] / 2)
    page.mouse.up()
    kappa = page.locator("input[aria-label=kappa]").input_value()
    assert float(kappa) > 1.25
    run = json.loads(chatter("simulate", "pressure_relief_valve", "--set", f"kappa={kappa}", "--until", "6", "--json"))
    assert view.motion(before)
    until(lambda: json.loads(view.data("history")["end"]) == list(run["state"].values()), "the motion of the slider's value")


def test_hanging_up_stops_the_work(view: View) -> None:
    # Long enough to be met at work.
    page = view.open(SMALL.replace("columns=128", "columns=4096").replace("keep=12", "keep=5000")).page
    until(lambda: view.data("diagram").get("state") == "computing" and view.explorer.questions() > 0, "work")
    page.goto("about:blank")
    until(lambda: view.explorer.questions() == 0, "the end of the work")


def test_an_address_brings_a_view_back(view: View) -> None:
    page = view.open(SMALL).page
    view.complete()
    view.motion()
    first = view.box()
    before = view.data("history")["end"]
    page.mouse.move(*view.middle("diagram"))
    page.mouse.wheel(0, -385)
    until(lambda: view.box() != first, "a zoom")
    view.complete()
    x, y = view.middle("diagram")
    page.mouse.click(x + 50, y)
    motion = view.motion(before)
    box, address = view.box(), page.evaluate("location.hash")
    assert "at=" in address
    page.reload()
    view.complete()
    assert view.motion(before)["end"] == motion["end"]
    assert view.box() == box
    assert page.evaluate("location.hash") == address
    for _ in range(3):
        if view.box() != box:
            break
        page.go_back()
        page.wait_for_timeout(300)
    until(lambda: view.box() != box, "the view before")


def test_what_a_view_gives_is_what_the_command_line_gives(view: View, tmp_path: Path) -> None:
    page = view.open(SMALL).page
    view.complete()
    page.locator("#diagram > header summary").click()
    with page.expect_download() as waiting:
        page.locator("#diagram > header .gifts").get_by_role("button", name="NPZ").click()
    ours = tmp_path / "ours.npz"
    waiting.value.save_as(ours)
    line = page.locator("#diagram > header .gifts code").first.text_content() or ""
    words = shlex.split(line)
    assert words[:2] == ["chatter", "diagram"]
    subprocess.run([BINARY, *words[1:]], cwd=tmp_path, check=True, capture_output=True)
    with np.load(ours) as one, np.load(tmp_path / "diagram.npz") as other:
        assert sorted(one.files) == sorted(other.files)
        for name in one.files:
            assert np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f"), name
    with page.expect_download() as waiting:
        page.locator("#diagram > header .gifts").get_by_role("button", name="SVG").click()
    picture = tmp_path / "ours.svg"
    waiting.value.save_as(picture)
    assert picture.read_bytes() == (tmp_path / "diagram.svg").read_bytes()


def test_keys_move_and_zoom(view: View) -> None:
    page = view.open(SMALL).page
    view.complete()
    low, high = view.box()
    page.locator("#diagram canvas").focus()
    page.keyboard.press("+")
    until(lambda: view.box() != (low, high), "a zoom")
    inner = view.box()
    assert low < inner[0] < inner[1] < high
    page.keyboard.press("Shift+ArrowRight")
    until(lambda: view.box()[0] > inner[0], "a move")
    page.keyboard.press("0")
    until(lambda: view.box() == (low, high), "everything")
    before = view.motion()["picked"]
    view.complete()
    page.keyboard.press("ArrowRight")
    until(lambda: view.data("history")["picked"] != before, "a step to the next column")


def test_an_orbit_is_dragged_along_its_branch(view: View) -> None:
    page = view.open(SMALL.replace("0.0205:0.0225", "0.0195:0.0196")).page
    view.complete()
    before = view.motion()["end"]
    page.get_by_role("button", name="Periodic orbits").click()
    until(lambda: "orbits on" in (page.locator(".overlay .status").text_content() or ""), "the branch")
    told = json.loads(chatter("continue", "pressure_relief_valve", "--sweep", "q=0.0195:0.0196", "--section", "closing", "--json"))
    assert page.locator(".special li").count() == sum(len(branch["special"]) for branch in told["branches"])
    points = told["branches"][0]["points"]
    middle = len(points["q"]) // 2
    ends = page.evaluate(
        """([x, y]) => { const plot = document.querySelector("#diagram canvas").plot;
            const { left, top } = plot.canvas.getBoundingClientRect(); return [left + plot.px(x), top + plot.py(y)]; }""",
        [points["q"][middle], points["y2"][middle]],
    )
    page.mouse.move(*ends)
    page.mouse.down()
    page.mouse.move(ends[0] + 3, ends[1])
    page.mouse.up()
    motion = view.motion(before)
    # It is one of the branch, and starts there.
    place = points["q"].index(float(motion["picked"]))
    start = [f"--initial={name}={points[name][place]!r}" for name in ("y1", "y2", "y3")]
    run = json.loads(chatter("simulate", "pressure_relief_valve", "--set", f"q={motion['picked']}", *start, "--until", "12", "--json"))
    assert json.loads(motion["end"]) == list(run["state"].values())


def test_a_map_over_two_parameters(view: View) -> None:
    page = view.open(SMALL.replace("columns=128", "columns=64") + "&second=kappa=1.2:1.3").page
    view.complete()
    assert int(view.data("diagram")["columns"]) >= 16 * 16
    assert page.locator("#diagram .legend .key").count() >= 1


def test_the_mechanism_moves(view: View) -> None:
    page = view.open(SMALL).page
    view.motion()
    assert page.locator("#mechanism canvas").is_visible()
    page.locator("#mechanism").get_by_role("button", name="Play").click()
    slider = page.locator("#mechanism input[aria-label=Time]")
    until(lambda: float(slider.input_value()) > 0.2, "some time to pass")
    page.locator("#mechanism").get_by_role("button", name="Pause").click()


def test_another_model_is_opened(view: View) -> None:
    page = view.open(SMALL).page
    before = view.motion()["end"]
    page.locator("header.top > select").select_option("bouncing_ball")
    before = view.motion(before)["end"]
    assert "restitution" in page.locator(".editor textarea").input_value()
    assert page.locator("#set-g").count() == 1
    # Its drawing has more parts than that of the one before.
    page.locator("header.top > select").select_option("newtons_cradle")
    view.motion(before)
    assert page.locator("#set-g").count() == 0
    assert len(json.loads(view.data("history")["end"])) == 6


@pytest.mark.parametrize("view", [(390, 844)], indirect=True)
def test_a_phone_is_wide_enough(view: View) -> None:
    page = view.open(SMALL.replace("0.0205:0.0225", "0.02:0.0225")).page
    view.complete()
    page.get_by_role("button", name="Chatter borders").click()
    until(lambda: page.locator(".overlay .gifts:visible").count(), "the border")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    # What views give is within the page's width, too.
    for menu in page.locator(".gifts:visible").all():
        menu.evaluate("(menu) => { menu.open = true; }")
        left, right = menu.evaluate("(menu) => { const { left, right } = menu.querySelector('.sheet').getBoundingClientRect(); return [left, right]; }")
        assert 0 <= left < right <= 390, menu.text_content()
        menu.evaluate("(menu) => { menu.open = false; }")


def test_a_million_points_are_panned_smoothly(view: View) -> None:
    # Of a model that costs little.
    page = view.open("#model=bouncing_ball_on_table&over=Gamma=1.2:4&observe=v&sampling=at:impact&columns=512&transient=30&keep=2000&time=0:2").page
    view.complete()
    count = "document.querySelector('#diagram canvas').rows.in_order().reduce((sum, { rows }) => sum + rows[0].samples.length, 0)"
    assert page.evaluate(count) > 1_000_000
    times = page.evaluate(
        """async () => { const canvas = document.querySelector("#diagram canvas");
            const { left, top } = canvas.getBoundingClientRect();
            canvas.setPointerCapture = () => {};
            const moved = (kind, x) => canvas.dispatchEvent(new PointerEvent(kind, { pointerId: 1, clientX: left + x, clientY: top + 150, bubbles: true }));
            const times = [];
            moved("pointerdown", 500);
            for (let k = 0; k < 120; k += 1) {
                times.push(await new Promise(requestAnimationFrame));
                moved("pointermove", 500 + 150 * Math.sin(k / 20));
            }
            moved("pointerup", 510);
            return times; }"""
    )
    between = np.diff(times)[5:]
    print(f"frames: mean {between.mean():.1f} ms, 95 % within {np.quantile(between, 0.95):.1f} ms")
    # 60 frames a second are 16.7 ms; a machine with other work drops some.
    assert np.median(between) < 20, between


def test_all_controls_are_reached_by_keys_and_show_it(view: View) -> None:
    page = view.open(SMALL).page
    view.complete()
    wanted = "[...document.querySelectorAll('button, select, input, textarea, canvas[tabindex], summary')].filter((one) => one.checkVisibility()).length"
    count = page.evaluate(wanted)
    seen = set()
    for _ in range(count + 3):
        page.keyboard.press("Tab")
        name, visible = page.evaluate(
            """() => { const one = document.activeElement; const frame = one.closest(".sheet") ?? one;
                const outlined = getComputedStyle(one).outlineStyle !== "none";
                const edged = getComputedStyle(frame).borderColor === getComputedStyle(document.querySelector(".mark")).backgroundColor;
                one.dataset.reached = ""; return [one.tagName, outlined || edged]; }"""
        )
        if name != "BODY":
            assert visible, name
            seen.add(name)
    assert page.locator("[data-reached]:not(body)").count() >= count


def test_everything_has_a_name(view: View) -> None:
    page = view.open(SMALL).page
    view.complete()
    nameless = page.evaluate(
        """[...document.querySelectorAll('button, select, input, textarea, canvas, summary, progress')].filter((element) =>
            !(element.getAttribute('aria-label') || element.textContent.trim() || element.labels?.length)).map((element) => element.outerHTML)"""
    )
    assert nameless == []
