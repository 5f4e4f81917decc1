"""The report as a browser shows it: offline and silent; its view turns and rolls, its numbers are right."""

from __future__ import annotations

import io
import json
import math
import shutil
import subprocess
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from .test_render_report import Page as ReportPage

sync_api = pytest.importorskip("playwright.sync_api", reason="needs the extra `browser`")
if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="needs chromium on the path (Debian's `chromium`)")
ARGUMENTS = (
    *("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
MODIFIED = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001")
FRAMES = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
COUNT_FRAMES = """() => new Promise(done => {
  const real = window.requestAnimationFrame;
  let count = 0;
  window.requestAnimationFrame = (act) => { count += 1; return real(act); };
  setTimeout(() => { window.requestAnimationFrame = real; done(count); }, 300);
})"""
NO_WEBGL = """const real = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return kind.startsWith("webgl") ? null : real.call(this, kind, ...rest);
};"""


@dataclass
class Seen:
    """A page and all it said and asked for."""

    page: Page
    messages: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def picture(self) -> NDArray[np.int_]:
        """Pixels of the view as it stands."""
        self.page.evaluate(FRAMES)
        png = self.page.locator("#view canvas").screenshot()
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)

    def camera(self) -> NDArray[np.float64]:
        return np.array(self.page.evaluate("pageView.camera()"))

    def roll(self) -> float:
        return float(self.page.evaluate("pageView.roll()"))

    def press(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).click()


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("report") / "report.html"
    command = Path(sysconfig.get_path("scripts")) / "render-report"
    run = [str(command), "--out", str(out), "--cases", "200", *MODIFIED]
    subprocess.run(run, check=True, capture_output=True, timeout=300)
    return out


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield launched
        launched.close()


@contextmanager
def opened(
    browser: Browser, report: Path, width: int = 640, script: str = "", **options: Any
) -> Iterator[Seen]:
    context = browser.new_context(viewport={"width": width, "height": 900}, **options)
    context.set_offline(True)
    seen = Seen(context.new_page())
    seen.page.on("console", lambda m: seen.messages.append(f"{m.type}: {m.text}"))
    seen.page.on("pageerror", lambda error: seen.messages.append(str(error)))
    seen.page.on("requestfailed", lambda request: seen.messages.append(f"failed: {request.url}"))
    seen.page.on("request", lambda request: seen.requests.append(request.url))
    if script:
        seen.page.add_init_script(script)
    seen.page.goto(report.as_uri())
    seen.page.locator("#view").scroll_into_view_if_needed()
    yield seen
    context.close()
    assert seen.messages == []
    assert seen.requests == [report.as_uri()]


@pytest.fixture(scope="module")
def seen(browser: Browser, report: Path) -> Iterator[Seen]:
    with opened(browser, report) as one:
        yield one


def colours(picture: NDArray[np.int_]) -> int:
    return len(np.unique(picture.reshape(-1, 3), axis=0))


def differing(one: NDArray[np.int_], other: NDArray[np.int_]) -> float:
    """Share of pixels that differ to the eye."""
    return float((np.abs(one - other).max(axis=-1) > 12).mean())


def test_the_view_shows_something_and_nothing_complains(seen: Seen) -> None:
    assert colours(seen.picture()) > 500
    assert seen.messages == []
    assert len(seen.requests) == 1
    assert seen.page.evaluate("performance.getEntriesByType('resource').length") == 0


def test_nothing_is_drawn_while_nothing_changes(seen: Seen) -> None:
    seen.page.evaluate(FRAMES)
    assert seen.page.evaluate(COUNT_FRAMES) == 0


def test_dragging_turns_the_pair(seen: Seen) -> None:
    seen.press("Pair")
    camera, picture = seen.camera(), seen.picture()
    box = seen.page.locator("#view canvas").bounding_box()
    assert box is not None
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    seen.page.mouse.move(x, y)
    seen.page.mouse.down()
    seen.page.mouse.move(x + 120, y + 40, steps=4)
    seen.page.mouse.up()
    turned = seen.camera()
    assert np.linalg.norm(turned[:3] - camera[:3]) > 50.0
    np.testing.assert_allclose(turned[3:], camera[3:], atol=1e-9)
    assert differing(picture, seen.picture()) > 0.1
    seen.press("Pair")
    np.testing.assert_allclose(seen.camera(), camera, atol=1e-6)


def test_the_wheel_belongs_to_the_page_until_the_view_has_the_focus(seen: Seen) -> None:
    seen.press("Pair")
    seen.page.locator("#view canvas").hover()
    camera = seen.camera()
    for focus, zooms in ((False, False), (True, True)):
        seen.page.evaluate("on => document.querySelector('#view canvas')[on ? 'focus' : 'blur']()", focus)
        place = seen.page.evaluate("scrollY")
        seen.page.mouse.wheel(0, -60)
        seen.page.wait_for_timeout(150)
        assert (seen.page.evaluate("scrollY") == place) == zooms
        assert bool(np.linalg.norm(seen.camera() - camera) > 1.0) == zooms


def test_the_slider_rolls_the_pair(seen: Seen) -> None:
    seen.press("Section at contact")
    picture, roll, text = seen.picture(), seen.roll(), seen.page.locator(".bv-roll").inner_text()
    slider = seen.page.get_by_role("slider")
    slider.fill("0.5")
    assert seen.roll() == pytest.approx(roll + 0.5 * 2.0 * math.pi / 29)
    assert seen.page.locator(".bv-roll").inner_text() != text
    assert "0.50 pitches" in seen.page.locator(".bv-roll").inner_text()
    assert differing(picture, seen.picture()) > 0.02
    slider.press("ArrowRight")
    assert seen.roll() == pytest.approx(roll + 0.51 * 2.0 * math.pi / 29)
    seen.page.evaluate("roll => pageView.setRoll(roll)", roll)
    assert differing(picture, seen.picture()) == 0.0
    assert "gear tip touches first" in seen.page.locator(".bv-contact").inner_text()


def test_every_view_and_flank_looks_different(seen: Seen) -> None:
    pictures = []
    for name in ("Pair", "Section at contact", "Left flanks", "Pinion flank", "Gear flank"):
        seen.press(name)
        assert seen.page.get_by_role("button", name=name).get_attribute("aria-pressed") == "true"
        pictures.append(seen.picture())
        assert colours(pictures[-1]) > 200
    assert min(differing(a, b) for i, a in enumerate(pictures) for b in pictures[:i]) > 0.002
    seen.press("Right flanks")


def test_keys_turn_and_gears_can_be_hidden(seen: Seen) -> None:
    seen.press("Pair")
    camera, picture = seen.camera(), seen.picture()
    seen.page.locator("#view canvas").focus()
    seen.page.keyboard.press("ArrowLeft")
    assert np.linalg.norm(seen.camera() - camera) > 10.0
    seen.page.keyboard.press("+")
    away = [float(np.linalg.norm(c[:3] - c[3:])) for c in (camera, seen.camera())]
    assert away[1] < 0.95 * away[0]
    seen.press("Pair")
    for way, least in (("see-through", 0.1), ("hidden", 0.15)):
        seen.page.get_by_label("gear", exact=False).last.select_option(label=way)
        assert differing(picture, seen.picture()) > least


@pytest.mark.parametrize(("flank", "sign"), [("Right flanks", 1.0), ("Left flanks", -1.0)])
def test_the_pinion_drives_while_it_plays(seen: Seen, flank: str, sign: float) -> None:
    seen.press("Pair")
    seen.press(flank)
    before = seen.roll()
    seen.press("Play")
    seen.page.wait_for_timeout(400)
    seen.press("Pause")
    after = seen.roll()
    assert 0.0 < sign * (after - before) < 0.3
    seen.page.wait_for_timeout(100)
    assert seen.roll() == after
    seen.press("Right flanks")


MISSES = """flank => {
  const data = JSON.parse(document.getElementById("view-data").textContent);
  const gears = beveloidGears(data), place = new THREE.Vector3(), misses = [];
  const missed = (line, point) => {
    const corners = line.geometry.attributes.instanceStart, away = [];
    for (let i = 0; i < corners.count; i++) {
      away.push(place.fromBufferAttribute(corners, i).applyMatrix4(line.matrixWorld).distanceTo(point));
    }
    return Math.min(...away);
  };
  for (let n = -10; n <= 10; n++) {
    const { found } = gears.pose(data.roll + 0.2 * n * gears.members[0].pitch, flank, false);
    gears.scene.updateMatrixWorld(true);
    found.forEach(({ point }, at) => {
      for (const { meshing } of gears.flanks[flank].drawn) misses.push(missed(meshing[at], point));
    });
  }
  return misses;
}"""


def test_paths_drawn_on_both_gears_run_through_the_dots(seen: Seen, flank: str) -> None:
    """As posed by the page itself: nearest corner of either polyline, of which there are 64 on some 20 mm."""
    misses = seen.page.evaluate(MISSES, flank)
    assert len(misses) >= 2 * 21
    assert max(misses) < 0.25


@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (1400, "dark")])
def test_narrow_and_wide_light_and_dark(browser: Browser, report: Path, width: int, scheme: str) -> None:
    with opened(browser, report, width, color_scheme=scheme) as seen:
        sizes = seen.page.evaluate("[document.scrollingElement.scrollWidth, innerWidth]")
        assert sizes[0] <= sizes[1]
        picture = seen.picture()
        assert colours(picture) > 500
        assert (picture[2, 2].mean() > 128) == (scheme == "light")
        seen.page.locator("#theme").click()
        assert (seen.picture()[2, 2].mean() > 128) == (scheme == "dark")


def test_without_webgl_a_sentence_stands_in_its_place(browser: Browser, report: Path) -> None:
    with opened(browser, report, script=NO_WEBGL) as seen:
        assert "needs WebGL" in seen.page.locator("#view").inner_text()
        assert seen.page.locator("#view canvas").count() == 0


def test_the_numbers_shown_are_those_of_the_file(seen: Seen, report: Path) -> None:
    """Which are those of the commands (`test_render_report.py`): no script changes them."""
    cells = "[...document.querySelectorAll('[data-key]')].map(e => [e.dataset.key, e.textContent])"
    written = ReportPage(report.read_text(encoding="utf-8")).cells
    shown = [tuple(cell) for cell in seen.page.evaluate(cells)]
    assert shown == [(attributes["data-key"], text) for attributes, text in written]


TEXT_SIZES = """() => [...document.querySelectorAll("svg.drawing text, svg.drawing tspan")]
  .filter((text) => text.textContent.trim())
  .map((text) => parseFloat(getComputedStyle(text).fontSize) * Math.abs(Math.hypot(
    text.getScreenCTM().a, text.getScreenCTM().b)))"""
TARGETS = """() => [...document.querySelectorAll("a, button, select, input, summary")]
  .map((each) => [each.textContent || each.type, each.getBoundingClientRect()])
  .filter(([, box]) => box.width)
  .map(([name, box]) => [name, box.width, box.height])"""
RIGHT_EDGES = """(kind) => [...document.querySelectorAll(`table.${kind}`)].map((table) =>
  [...table.querySelectorAll("tbody tr:first-child td")].map((cell) => cell.getBoundingClientRect().right -
    table.getBoundingClientRect().left))"""
SCROLLED = """() => [...document.querySelectorAll(".scroll, nav ul")]
  .filter((box) => box.scrollWidth > box.clientWidth)
  .map((box, n) => { box.id ||= `scrolled-${n}`; return box.id; })"""


@pytest.fixture(scope="module")
def narrow(browser: Browser, report: Path) -> Iterator[Seen]:
    with opened(browser, report, 390) as one:
        yield one


def test_letters_of_charts_are_legible_on_a_narrow_page(narrow: Seen) -> None:
    sizes = narrow.page.evaluate(TEXT_SIZES)
    assert len(sizes) > 300
    assert min(sizes) >= 11.0
    assert max(sizes) < 16.0


def test_targets_are_as_wide_as_a_finger(narrow: Seen) -> None:
    """Links, buttons, the slider, lists, and what opens: 44 pixels either way."""
    targets = narrow.page.evaluate(TARGETS)
    assert len(targets) > 30
    assert [target for target in targets if min(target[1:]) < 44.0] == []


@pytest.mark.parametrize("width", [390, 1280, 1920])
def test_nothing_stands_out_at_the_sides_and_the_verdict_is_on_the_first_screen(
    browser: Browser, report: Path, width: int
) -> None:
    with opened(browser, report, width) as seen:
        assert seen.page.evaluate("document.scrollingElement.scrollWidth") <= width
        seen.page.evaluate("scrollTo(0, 0)")
        for name in ("h1", ".made", ".verdict", ".verdict .warning", ".share", ".pair-picture"):
            box = seen.page.locator(name).first.bounding_box()
            assert box is not None
            below = 0.0 if (name, width) == (".pair-picture", 390) else box["height"]
            assert 0.0 <= box["y"] <= box["y"] + below < 900.0, name
            assert 0.0 <= box["x"] < box["x"] + box["width"] <= width, name
        words, picture = (seen.page.locator(name).bounding_box() for name in (".verdict", ".pair-picture"))
        assert words is not None
        assert picture is not None
        assert (picture["x"] > words["x"] + words["width"]) == (width > 1000)  # beside it, or below


def test_the_contents_stay_and_say_where_one_is(narrow: Seen) -> None:
    """A heading that was jumped to stands below them, and its name in them is in sight."""
    for name in ("Pressure", "Terms", "Design"):
        link = narrow.page.get_by_role("link", name=name, exact=True)
        link.click()
        narrow.page.evaluate(FRAMES)
        contents = narrow.page.locator("nav").bounding_box()
        heading = narrow.page.locator(f"{link.get_attribute('href')} h2").bounding_box()
        own = link.bounding_box()
        assert contents is not None
        assert heading is not None
        assert own is not None
        assert contents["y"] == 0.0
        assert heading["y"] >= contents["height"]
        assert narrow.page.locator("nav [aria-current]").all_inner_texts() == [name]
        assert own["x"] >= 0.0
        assert own["x"] + own["width"] <= 390.0


def test_what_scrolls_sideways_shows_it(narrow: Seen) -> None:
    """A shadow stands at the side where there is more, and none at an end."""

    def levels(which: str) -> tuple[int, int]:
        """Of grey at both sides, clear of words and of the first column, which stays."""
        narrow.page.evaluate(FRAMES)
        picture = np.asarray(
            Image.open(io.BytesIO(narrow.page.locator(f"#{which}").screenshot())).convert("L")
        )
        first = narrow.page.evaluate(
            "id => document.querySelector(`#${id} th`) && document.querySelector(`#${id} th`).offsetWidth",
            which,
        )
        return tuple(int(np.median(picture[:, x])) for x in (-1 if first else 0, -1))  # type: ignore[return-value]

    found = narrow.page.evaluate(SCROLLED)
    assert len(found) == 6  # the contents, the ease-off, sensitivities and quantiles of both flanks
    for which in found:
        narrow.page.evaluate("id => document.getElementById(id).scrollTo(0, 0)", which)
        assert levels(which)[1] < 215, which
        narrow.page.evaluate("id => document.getElementById(id).scrollTo(9999, 0)", which)
        left, right = levels(which)
        assert right > 240, which
        if which.endswith("-0"):
            assert left < 215, which
        narrow.page.evaluate("id => document.getElementById(id).scrollTo(0, 0)", which)


@pytest.mark.parametrize("width", [390, 1280])
def test_right_stands_under_right_and_left_under_left(browser: Browser, report: Path, width: int) -> None:
    with opened(browser, report, width) as seen:
        short = [edges for edges in seen.page.evaluate(RIGHT_EDGES, "short") if len(edges) == 2]
        assert len(short) >= 8
        assert np.ptp(short, axis=0).max() < 0.6
        wide = seen.page.evaluate(RIGHT_EDGES, "wide")
        assert [len(edges) for edges in wide] == [4, 4, 4, 6, 6]
        assert np.ptp(wide[:3], axis=0).max() < 0.6
        assert np.ptp(wide[3:], axis=0).max() < 0.6
        tops = seen.page.evaluate(
            "[...document.querySelectorAll('figure.chart')].map(e => e.getBoundingClientRect().height)"
        )
        assert len(tops) == 20
        names = seen.page.evaluate(
            "[...document.querySelectorAll('.drawing > title')].map(e => e.textContent)"
        )
        heights = dict(zip(names, tops, strict=True))
        for name, height in heights.items():
            other = name.replace("right flanks", "left flanks")
            assert heights[other] == pytest.approx(height, abs=0.6), name


CELLS = """() => [...document.querySelectorAll("table.cells")].map((table) => [
  [...table.querySelectorAll("thead th")],
  ...[...table.querySelectorAll("tbody tr:has(td)")].map((row) => [...row.cells])
].map((row) => row.map((cell) => [cell.getBoundingClientRect().left, cell.getBoundingClientRect().right,
  cell.scrollWidth - cell.clientWidth, parseFloat(getComputedStyle(cell).fontSize)])))"""


@pytest.mark.parametrize("width", [390, 1280, 1920])
def test_patterns_under_errors_stand_under_their_errors(browser: Browser, report: Path, width: int) -> None:
    """Legible, and no word beyond its cell."""
    with opened(browser, report, width) as seen:
        tables = np.array(seen.page.evaluate(CELLS))
        assert tables.shape == (2, 4, 3, 4)  # a head and three rows
        assert np.ptp(tables[..., :2], axis=1).max() < 0.6
        assert tables[..., 2].max() <= 0.0
        assert tables[..., 3].min() >= 13.0


def test_saved_numbers_carry_the_name_of_the_design(browser: Browser, report: Path) -> None:
    page = browser.new_page()
    page.goto(report.as_uri())
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save numbers").click()
    assert saved.value.suggested_filename == "ni-2017.json"
    data = json.loads(saved.value.path().read_text(encoding="utf-8"))
    assert data["name"] == "ni-2017"
    assert data["ease_off"]["design"] == data["tca"]["left"]["design"] == "ni-2017"
    page.close()


def test_without_javascript_all_but_the_view_is_there(browser: Browser, report: Path) -> None:
    with opened(browser, report, 1280, java_script_enabled=False) as seen:
        assert "picture at the top" in seen.page.locator("#view").inner_text()
        assert not seen.page.locator(".tools").is_visible()
        for name in (".verdict", ".pair-picture", "#path-right-title >> xpath=..", "nav"):
            assert seen.page.locator(name).first.is_visible(), name
        picture = seen.page.locator(".pair-picture").screenshot()
        assert colours(np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)) > 10


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_on_paper(browser: Browser, report: Path, scheme: str) -> None:
    """White whatever the screen is, nothing beyond the margins of A4 (190 mm), no buttons."""
    with opened(browser, report, 718, color_scheme=scheme) as seen:
        seen.page.emulate_media(media="print")
        assert seen.page.evaluate("document.scrollingElement.scrollWidth") <= 718
        assert seen.page.evaluate(
            "[...document.querySelectorAll('table')].every(t => t.getBoundingClientRect().right <= 718)"
        )
        assert not seen.page.locator("nav").is_visible()
        assert not seen.page.locator(".tools").is_visible()
        assert seen.page.locator(".pair-picture").is_visible()
        assert seen.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        assert min(seen.page.evaluate(TEXT_SIZES)) > 9.3  # 7 points
