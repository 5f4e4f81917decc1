"""The window in Chromium: drag, undo, compare, save, reload, keyboard, narrow and dark."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from beveloid_geom import Design, contact_pattern, read_design
from beveloid_viz.explore.calculation import Calculation
from beveloid_viz.explore.values import Start
from tests.viz.report.browsing import collect_messages

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from beveloid_viz.explore.notebook import Exploration

pytestmark = pytest.mark.slow
WATCH = """window.seen = [];
document.addEventListener("explored", ({ detail }) => window.seen.push(detail));
window.received = [];
window.WebSocket = class extends WebSocket {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({ data }) => window.received.push(JSON.parse(data)));
  }
};"""
SETTLED = "window.seen.some(one => one.last && one.id === one.newest && one.newest >= %d)"
DRAG = """async ([name, values]) => {
  const slider = document.querySelector(`#value-${name} ~ input`);
  for (const value of values) {
    slider.value = value;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await new Promise((done) => setTimeout(done, 15));
  }
  slider.dispatchEvent(new Event("change", { bubbles: true }));
}"""
CONTRAST = """() => {
  const channel = (v) => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const light = (css) => { const [r, g, b] = css.match(/[\\d.]+/g).map(Number);
    return 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b); };
  const paper = light(getComputedStyle(document.body).backgroundColor);
  const ratio = (l) => (Math.max(l, paper) + 0.05) / (Math.min(l, paper) + 0.05);
  return [...document.querySelectorAll("label, td, th, figcaption, .unit, .key span, summary, li")]
    .filter((each) => each.getClientRects().length)
    .map((each) => [each.textContent, ratio(light(getComputedStyle(each).color))]);
}"""
OUTSIDE = """() => [...document.querySelectorAll("#pinion text, #gear text, #graph text")].filter((text) => {
  const box = text.getBoundingClientRect(), frame = text.ownerSVGElement.getBoundingClientRect();
  return box.left < frame.left - 1 || box.right > frame.right + 1 || box.bottom > frame.bottom + 1;
}).map((text) => text.textContent)"""
STARTS = "[...document.querySelectorAll('#figures td.start')].map((e) => e.textContent.split(' ')[0])"
WIDTH = "document.querySelector('#pinion').getAttribute('width')"
STARTED = "window.received.some(one => one.kind === 'start' && one.last)"
NAMELESS = """() => [...document.querySelectorAll("input, select, button")].filter((each) =>
  !(each.labels?.length || each.getAttribute("aria-label") || each.textContent.trim())).length"""


@contextmanager
def window(browser: Browser, url: str, width: int = 1280, **options: Any) -> Iterator[Page]:
    context = browser.new_context(viewport={"width": width, "height": 900}, **options)
    messages: list[str] = []
    requests: list[str] = []
    page = context.new_page()
    collect_messages(page, messages)
    page.on("request", lambda request: requests.append(request.url))
    page.add_init_script(WATCH)
    page.goto(url)
    settled(page)
    yield page
    context.close()
    assert messages == []
    local = (url, url.replace("http", "ws", 1), "data:", "blob:")
    assert [request for request in requests if not request.startswith(local)] == []


def settled(page: Page, newest: int = 1) -> None:
    """Wait until the newest values are shown completely."""
    wait_for(page, SETTLED % newest)


def wait_for(page: Page, script: str) -> None:
    """Wait until a script is true. The page forbids the way in which Playwright waits for scripts."""
    end = time.monotonic() + 30.0
    while not page.evaluate(script):
        assert time.monotonic() < end, (script, page.evaluate("JSON.stringify(window.seen)"))
        time.sleep(0.05)


def changed(page: Page, act: Callable[[], Any]) -> None:
    """Act, and wait for the results."""
    before = int(page.evaluate("Math.max(...window.seen.map(one => one.newest))"))
    act()
    settled(page, before + 1)


def figures(page: Page) -> dict[str, str]:
    script = "[...document.querySelectorAll('[data-figure]')].map(e => [e.dataset.figure, e.textContent])"
    return {name: text.split()[0].replace("\u2212", "-") for name, text in page.evaluate(script)}


def expected(design: Design, **values: Any) -> dict[str, str]:
    found = Calculation(*Start(design).read(values))
    stages = (found.motion(), found.pattern(), found.remarks())
    return {figure["name"]: figure["text"] for stage in stages for figure in stage["figures"]}


def drag(page: Page, name: str, *values: float) -> None:
    changed(page, lambda: page.evaluate(DRAG, [name, list(values)]))


@pytest.fixture(scope="module")
def url(explored: Callable[..., Exploration], modified: Design) -> str:
    return explored(modified, name="ni-2017").url


def test_drag_undo_reset_compare_save_and_reload(
    browser: Browser, url: str, modified: Design, tmp_path: Path
) -> None:
    with window(browser, url) as page:
        start = figures(page)
        assert start == expected(modified)
        picture = page.locator("#pinion").inner_html()
        drag(page, "offset_error", *(0.005 * k for k in range(1, 11)))
        assert figures(page) == expected(modified, offset_error=0.05)
        assert page.locator("#pinion").inner_html() != picture
        assert page.get_by_label("Offset", exact=True).input_value() == "0.05"
        drag(page, "film", 0.01)

        page.get_by_role("button", name="Compare with start").click()
        page.locator("#figures.compared td.start", has_text=start["ratio"]).wait_for()
        assert page.get_by_role("button", name="Compare").get_attribute("aria-pressed") == "true"

        with page.expect_download() as saved:
            page.get_by_role("button", name="Save design file").click()
        saved.value.save_as(tmp_path / saved.value.suggested_filename)
        assert read_design(tmp_path / "ni-2017-changed.toml").errors.offset == 0.05
        page.get_by_role("button", name="Copy command line").click()
        page.locator("#answer", has_text="--offset-error=0.05").wait_for()
        with page.expect_download() as picture_file:
            page.get_by_role("button", name="Download picture").click()
        picture_file.value.save_as(tmp_path / "picture.png")
        assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")

        page.reload()
        settled(page)
        assert page.get_by_label("Offset", exact=True).input_value() == "0.05"
        assert figures(page) == expected(modified, offset_error=0.05, film=0.01)
        drag(page, "gear_axial_error", 0.1)
        changed(page, lambda: page.get_by_role("button", name="Undo").click())
        assert figures(page) == expected(modified, offset_error=0.05, film=0.01)
        assert page.get_by_role("button", name="Undo").is_disabled()
        changed(page, lambda: page.get_by_role("button", name="Reset").click())
        assert figures(page) == start


def test_the_start_has_the_settings_of_the_window(browser: Browser, url: str, modified: Design) -> None:
    """The curves of the start have the flanks and the film of the window, also after undo and reset, and if
    the flanks change before the start is computed."""
    with window(browser, url) as page:
        choice = page.get_by_label("Driving flanks").first
        film = page.get_by_label("Film thickness", exact=True)

        def compared(**values: Any) -> None:
            expect = list(expected(modified, **values).values())
            end = time.monotonic() + 30.0
            while page.evaluate(STARTS) != expect:
                assert time.monotonic() < end, (page.evaluate(STARTS), expect)
                time.sleep(0.05)

        page.get_by_role("button", name="Compare with start").click()
        for flank in ("left", "right", "left", "right", "left"):
            choice.select_option(flank)
            page.wait_for_timeout(150)
        compared(flank="left")
        changed(page, lambda: page.get_by_role("button", name="Undo").click())
        compared()
        changed(page, lambda: film.fill("0.01"))
        page.keyboard.press("Tab")
        compared(film=0.01)
        changed(page, lambda: page.get_by_role("button", name="Reset").click())
        compared()


def test_without_film_there_is_no_pattern(browser: Browser, url: str, modified: Design) -> None:
    with window(browser, url) as page:
        changed(page, lambda: page.get_by_label("Film thickness", exact=True).fill("0"))
        assert figures(page) == expected(modified, film=0.0)
        assert "pinion_pattern" not in figures(page)


def test_refused_jammed_and_lost_pairs_grey_the_last_picture(browser: Browser, url: str) -> None:
    with window(browser, url) as page:
        number, words = page.get_by_label("Offset", exact=True), page.locator("#verdict .words")
        before = figures(page)
        for value, text in (("9999", "Value refused"), ("-0.5", "The pair jams")):
            changed(page, lambda value=value: number.fill(value))  # type: ignore[misc]
            assert words.inner_text().startswith(text)
            assert page.locator("#panels.old").count() == 1
            assert number.get_attribute("aria-invalid") == str(value == "9999").lower()
        assert figures(page) == before
        changed(page, lambda: number.fill("0"))
        assert page.locator(".old").count() == 0
        assert figures(page) == before


def test_a_pair_that_jams_in_the_last_stage_greys_the_last_valid_picture(
    browser: Browser, url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Flanks, motion graph, quantities and teeth are those of the valid values, not a mixture."""
    with window(browser, url) as page:
        drag(page, "offset_error", 0.05)

        def shown() -> list[Any]:
            parts = [page.locator(f"#{name}").inner_html() for name in ("pinion", "gear", "graph")]
            return [*parts, figures(page), page.evaluate(PATTERN), page.evaluate(PATHS)]

        valid = shown()
        with monkeypatch.context() as patch:
            patch.setattr("beveloid_viz.explore.calculation.SMALL_BACKLASH_MM", -1.0)
            changed(page, lambda: page.get_by_label("Offset", exact=True).fill("-0.2"))
            stages = page.evaluate("window.seen.filter(one => one.id === one.newest).map(one => one.stage)")
        assert stages[-1] == "remarks"
        assert page.locator("#verdict .words").inner_text().startswith("The pair jams")
        assert page.locator("#panels.old").count() == 1
        assert shown() == valid
        changed(page, lambda: page.get_by_label("Offset", exact=True).fill("0.05"))
        assert page.locator(".old").count() == 0
        assert shown() == valid


def test_a_grey_picture_keeps_its_flanks(browser: Browser, url: str) -> None:
    """If the flanks change while a value is refused, the caption is that of the picture, and curves and
    quantities of the start, which has the new flanks, are not shown with it."""
    with window(browser, url) as page:
        caption, right = page.locator("#side"), "Right flanks, seen from outside."
        assert caption.inner_text() == right
        before = figures(page)
        changed(page, lambda: page.get_by_label("Offset", exact=True).fill("500"))
        changed(page, lambda: page.get_by_label("Driving flanks").first.select_option("left"))
        width = page.evaluate(WIDTH)
        page.set_viewport_size({"width": 900, "height": 900})
        wait_for(page, f"{WIDTH} !== '{width}'")
        assert caption.inner_text() == right
        alone = page.locator("#graph").inner_html()
        page.get_by_role("button", name="Compare with start").click()
        wait_for(page, STARTED)
        assert caption.inner_text() == right
        assert page.locator("#graph").inner_html() == alone
        assert figures(page) == before
        assert set(page.evaluate(STARTS)) == {""}
        changed(page, lambda: page.get_by_label("Offset", exact=True).fill("0"))
        assert caption.inner_text() == "Left flanks, seen through the tooth."
        assert page.evaluate(STARTS) == list(figures(page).values())


def test_the_answer_to_an_action_is_removed_with_the_next_value(browser: Browser, url: str) -> None:
    with window(browser, url) as page:
        answer, number = page.locator("#answer"), page.get_by_label("Offset", exact=True)
        save = page.get_by_role("button", name="Save design file")
        undo, flanks = page.get_by_role("button", name="Undo"), page.get_by_label("Driving flanks").first
        changed(page, lambda: number.fill("500"))
        save.click()
        page.locator("#answer", has_text="must be between").wait_for()
        changed(page, lambda: number.fill("0.05"))
        assert answer.inner_text() == ""
        page.keyboard.press("Tab")
        for act in (lambda: flanks.select_option("left"), undo.click):
            with page.expect_download():
                save.click()
            page.locator("#answer", has_text="Saved as").wait_for()
            changed(page, act)
            assert answer.inner_text() == ""


def test_two_windows_are_independent(browser: Browser, url: str, modified: Design) -> None:
    with window(browser, url) as one, window(browser, url) as other:
        drag(one, "offset_error", 0.05)
        assert figures(other) == expected(modified)
        drag(other, "offset_error", 0.02)
        assert figures(one) == expected(modified, offset_error=0.05)
        assert figures(other) == expected(modified, offset_error=0.02)


def test_the_other_flanks_errors_at_the_mesh_and_roll(browser: Browser, url: str, modified: Design) -> None:
    with window(browser, url) as page:
        changed(page, lambda: page.get_by_label("Driving flanks").first.select_option("left"))
        assert figures(page) == expected(modified, flank="left")
        assert page.get_by_role("button", name="Left flanks").get_attribute("aria-pressed") == "true"
        changed(page, lambda: page.get_by_role("button", name="Right flanks").click())
        drag(page, "offset_error", 0.05)
        before = figures(page)
        changed(page, lambda: page.get_by_label("Measured at").select_option("mesh"))
        assert figures(page) == before
        assert page.get_by_label("Offset", exact=True).is_hidden()
        roll = page.evaluate("exploreView.roll()")
        page.get_by_role("button", name="Play").click()
        page.wait_for_timeout(300)
        page.get_by_role("button", name="Pause").click()
        assert page.evaluate("exploreView.roll()") > roll


def test_keyboard_alone_changes_and_takes_back(browser: Browser, url: str, modified: Design) -> None:
    with window(browser, url) as page:
        page.locator("#value-errors_at").focus()
        page.keyboard.press("Tab")
        page.keyboard.press("Tab")  # from the number to the slider
        assert page.evaluate("document.activeElement.getAttribute('aria-label')") == "Offset, mm"
        outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline != "none"
        changed(page, lambda: page.keyboard.press("ArrowRight"))
        assert figures(page) == expected(modified, offset_error=0.005)
        changed(page, lambda: page.keyboard.press("Control+z"))
        assert figures(page) == expected(modified)
        page.locator("summary", has_text="Pinion, right flanks").focus()
        page.keyboard.press("Enter")
        assert page.get_by_label("Helix crowning", exact=True).first.is_visible()


@pytest.mark.parametrize(("width", "scheme"), [(390, "dark"), (1280, "light")])
def test_narrow_and_wide_dark_and_light(browser: Browser, url: str, width: int, scheme: str) -> None:
    with window(browser, url, width, color_scheme=scheme) as page:
        for summary in page.locator("summary:visible").all()[2:]:
            summary.click()
        assert page.evaluate("document.scrollingElement.scrollWidth <= innerWidth")
        paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert (int(re.findall(r"\d+", paper)[0]) > 128) == (scheme == "light")
        assert page.evaluate(OUTSIDE) == []
        assert page.evaluate(NAMELESS) == 0
        faint = [(text, ratio) for text, ratio in page.evaluate(CONTRAST) if ratio < 4.5]
        assert faint == []


PATHS = "JSON.stringify(exploreView.gears.flanks.right.path)"
PATTERN = """() => exploreView.gears.members.map(({ spin }) => {
  const { geometry } = spin.children.find((each) => each.renderOrder === 12);
  const at = geometry.attributes.position.array, corners = geometry.index.array;
  let area = 0.0;
  for (let n = 0; n < corners.length; n += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => at.slice(3 * corners[n + k], 3 * corners[n + k] + 3));
    const [p, q] = [b, c].map((each) => each.map((value, k) => value - a[k]));
    area += 0.5 * Math.hypot(p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]);
  }
  return [area, corners.length / 3];
})"""


def test_pattern_on_the_teeth_has_few_triangles_and_the_area_of_the_pattern(
    browser: Browser, url: str, modified: Design
) -> None:
    film = 0.003
    with window(browser, url) as page:
        drag(page, "film", film)
        shown = page.evaluate(PATTERN)
    pattern = contact_pattern(modified, "right", film)
    for side, (area, triangles) in zip((pattern.pinion, pattern.gear), shown, strict=True):
        assert area == pytest.approx(side.area, rel=0.05)  # the grid of the view has 13 rows
        assert triangles < 400
