"""The report in a browser: numbers and layout on screens and on paper."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

from .browsing import FRAMES, Seen, colours, opened
from .report_page import ReportPage

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator


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


def test_the_numbers_shown_are_those_of_the_file(seen: Seen, report: Path) -> None:
    """Scripts leave the numbers of the commands (`test_render_report.py`) unchanged."""
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
    """Links, buttons, sliders, lists and details are at least 44 pixels wide and high."""
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
        assert (picture["x"] > words["x"] + words["width"]) == (width > 1000)  # to the right, or below


def press_in_contents(seen: Seen, link: Locator) -> None:
    """Press a link as a reader does, who moves the contents sideways and not the page.

    `Locator.click` first scrolls the page to centre the link, and the browser then sometimes drops the jump.
    """
    link.evaluate("link => { link.closest('ul').scrollLeft = link.offsetLeft; }")
    seen.page.evaluate(FRAMES)
    box = link.bounding_box()
    assert box is not None
    seen.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])


def test_contents_stay_visible_and_mark_the_section(narrow: Seen) -> None:
    """After a jump, the heading is below the contents, and its entry is visible."""
    for name in ("Pressure", "Terms", "Design"):
        link = narrow.page.get_by_role("link", name=name, exact=True)
        press_in_contents(narrow, link)
        marked = "name => document.querySelector('nav [aria-current]')?.textContent === name"
        narrow.page.wait_for_function(marked, arg=name)
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


def test_scrollable_tables_have_a_shadow(narrow: Seen) -> None:
    """A shadow marks the side of a table with hidden columns; a table that is scrolled to its end has none
    there."""

    def levels(which: str) -> tuple[int, int]:
        """Return the grey levels at both sides, away from text and from the fixed first column."""
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
    assert len(found) == 6  # contents, ease-off, sensitivities and quantiles of both flanks
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
def test_patterns_are_below_their_errors(browser: Browser, report: Path, width: int) -> None:
    """Each pattern is below the text of its errors, which is legible and stays within its cell."""
    with opened(browser, report, width) as seen:
        tables = np.array(seen.page.evaluate(CELLS))
        assert tables.shape == (2, 4, 3, 4)  # a heading and three rows
        assert np.ptp(tables[..., :2], axis=1).max() < 0.6
        assert tables[..., 2].max() <= 0.0
        assert tables[..., 3].min() >= 13.0


def test_details_are_folded_and_open_by_links(browser: Browser, report: Path) -> None:
    with opened(browser, report, 1280, folded=True) as seen:
        assert seen.page.evaluate("document.scrollingElement.scrollHeight") < 6178  # half of the first design
        chart = seen.page.locator("#sensitivity-left-title >> xpath=..")
        assert not chart.is_visible()
        seen.page.get_by_role("link", name="Sensitivity", exact=True).click()
        assert chart.is_visible()
        seen.page.emulate_media(media="print")
        assert seen.page.locator("#sliding-left-title >> xpath=..").is_visible()


def test_sliders_choose_the_pattern_under_errors(browser: Browser, report: Path) -> None:
    with opened(browser, report, 390, folded=True) as seen:
        cells = seen.page.locator("table.cells td:visible")
        assert cells.count() == 2
        middle = cells.first.inner_text()
        seen.page.locator("#second-error").focus()
        seen.page.keyboard.press("ArrowRight")
        assert seen.page.locator("output[for=second-error]").inner_text() == "0.0100°"
        assert seen.page.locator("output[for=first-error]").inner_text() == "0.000 mm"
        assert cells.first.inner_text() != middle
        last = seen.page.locator("table.cells").first.locator("td").nth(5)
        assert cells.first.inner_text() == last.inner_text()
        seen.press("All together")
        assert cells.count() == 18


def test_shortened_numbers_show_all_digits_on_focus(narrow: Seen) -> None:
    number = narrow.page.locator("#design .n").first
    number.evaluate("(e) => { e.tabIndex = 0; e.dataset.full = '0.00012344'; }")
    number.focus()
    assert number.evaluate("(e) => getComputedStyle(e, '::after').content") == '"0.00012344"'
    number.evaluate("(e) => delete e.dataset.full")


def test_saved_numbers_contain_the_name_of_the_design(browser: Browser, report: Path) -> None:
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
    with opened(browser, report, 1280, folded=True, java_script_enabled=False) as seen:
        assert "picture at the top" in seen.page.locator("#view").inner_text()
        assert not seen.page.locator(".tools").is_visible()
        for name in (".verdict", ".pair-picture", "#path-right-title >> xpath=..", "nav"):
            assert seen.page.locator(name).first.is_visible(), name
        assert seen.page.locator("table.cells td").last.is_visible()
        seen.page.locator("#pressure summary").click()
        assert seen.page.locator("#pressure-right-title >> xpath=..").is_visible()
        picture = seen.page.locator(".pair-picture").screenshot()
        assert colours(np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)) > 10


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_on_paper(browser: Browser, report: Path, scheme: str) -> None:
    """A printed page is white for any setting of the screen, fits into the margins of A4 (190 mm), and has no
    buttons."""
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
