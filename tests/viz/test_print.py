"""Pages for print: text does not overlap and is not cut, and pages and files have the right size."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.lines import Line2D
from matplotlib.text import Text
from PIL import Image

from beveloid_geom import Design, Member, Pair, builtin_design
from beveloid_viz.cli import main
from beveloid_viz.figures import FIGURES, Figure
from beveloid_viz.rendering import files, theme, typeset
from beveloid_viz.rendering.layout import PAPER_INCHES_PER_INCH, PageLayout, PanelRows, of_size, of_width
from beveloid_viz.rendering.theme import Page

from ..symmetry import mirrored, scaled
from .pages import recipe_of, short_measurements, words

WIDTHS = (90.0, 190.0)
HIGHEST = 235.0
"""Largest height of a page, mm."""
DPI = 70.0
"""Resolution; the space of text does not depend on it."""
TABLE = builtin_design()


def both_right() -> Design:
    """Return a pair with two right-hand members."""
    tool = replace(TABLE.pinion.tool, normal_module=2.5)
    angles = np.radians([[14.0, 3.0], [8.0, 2.0]])
    pinion, gear = (
        Member(tool, teeth, helix, cone, 0.1, width)
        for teeth, width, (helix, cone) in zip((25, 61), (20.0, 22.0), angles, strict=True)
    )
    return Design(pinion, gear, Pair(107.2317, 0.3946795))


def straight_undercut() -> Design:
    """Return a straight cylindrical pair whose pinion of 7 teeth is undercut."""
    tool = replace(TABLE.pinion.tool, normal_module=2.0)
    pinion, gear = (Member(tool, teeth, 0.0, 0.0, 0.0, 20.0) for teeth in (7, 40))
    return Design(pinion, gear, Pair(47.1, 0.0))


DESIGNS = {"table1": TABLE, "both_left": scaled(mirrored(both_right()), 0.8)}
BUILT_IN = {name: builtin_design(name) for name in ("awd-transfer", "marine-gearbox", "anti-backlash")}
"""Designs with axes that intersect far away, and with parallel axes."""
ALSO_BUILT_IN = ("fig-01", "fig-03", "fig-04", "fig-05", "fig-13", "method", "ease-off", "posed-pair")
"""Figures that are also laid out for these designs."""
SMALL = {"small": scaled(TABLE, 0.05)}
"""Module 0.3 mm, at which numbers on axes have more decimals."""
ALSO_SMALL = ("fig-14", "ease-off", "transmission-error")
"""Figures that are also laid out for this design."""
LEAST_SHARES = {
    "fig-05": 0.14,
    "fig-07": 0.145,
    "fig-12": 0.2,
    "fig-13": 0.19,
    "fig-14": 0.2,
    "separation": 0.15,
}
"""Smallest fraction of the page that surfaces cover in print."""
QUICK = ("fig-02", "fig-09", "sensitivity")


@pytest.fixture(scope="module", autouse=True)
def _small_studies() -> Iterator[None]:
    with short_measurements():
        yield


def in_print(width_mm: float, plain: bool = False) -> PageLayout:
    return replace(of_width(width_mm, plain), dpi=DPI * PAPER_INCHES_PER_INCH)


def assert_printable(page: Page, width: float) -> None:
    """Assert the width (mm) and the largest height of a page, and that its text has no faults."""
    wide, high = page.get_size_inches() * PAPER_INCHES_PER_INCH * 25.4
    assert wide == pytest.approx(width, abs=0.05)
    assert high <= HIGHEST, f"{width:g} mm"
    assert faults(page) == [], f"{width:g} mm"


def faults(page: Page) -> list[str]:
    """Return the faults of the text on a page."""
    with theme.style():
        words = typeset.visible_text(page)
    width, height = page.canvas.get_width_height()
    found = []
    for k, (text, box) in enumerate(words):
        name = repr(text.get_text())
        if min(box.x0, box.y0) < -0.5 or box.x1 > width + 0.5 or box.y1 > height + 0.5:
            found.append(f"{name} is cut")
        points = float(text.get_fontsize()) * PAPER_INCHES_PER_INCH
        if not 6.99 < points < 9.01:
            found.append(f"{name} has {points:.2f} points")
        for other, beside in words[k + 1 :]:
            over = np.minimum(box.max, beside.max) - np.maximum(box.min, beside.min)
            if (over > 1.0).all():
                found.append(f"{name} on {other.get_text()!r}")
    return found


@pytest.mark.parametrize(
    ("figure", "design"),
    [
        pytest.param(
            figure,
            design,
            id=f"{figure.name}-{design}",
            marks=() if figure.name in QUICK and design == "table1" else pytest.mark.slow,
        )
        for figure in FIGURES
        for design in (
            *DESIGNS,
            *(BUILT_IN if figure.name in ALSO_BUILT_IN else ()),
            *(SMALL if figure.name in ALSO_SMALL else ()),
        )
    ],
)
def test_words_are_apart_whole_and_large_enough(figure: Figure, design: str) -> None:
    """Pages of Table 1 at both widths, those of other designs at the smaller one. Surfaces of Table 1 with
    their text cover a fraction of the page."""
    recipe = figure.recipe()
    data = recipe.compute((DESIGNS | BUILT_IN | SMALL)[design])
    for width in WIDTHS if design == "table1" else WIDTHS[:1]:
        drawing = recipe.drawn(data, in_print(width))
        assert_printable(drawing.page, width)
        if design == "table1" and figure.name in LEAST_SHARES:
            covered = sum(int((one.image.min(axis=-1) < 250).sum()) for one in drawing.pictures.values())
            share = covered / np.prod(drawing.page.canvas.get_width_height())
            assert share > LEAST_SHARES[figure.name], f"{width:g} mm"


@pytest.mark.parametrize("name", ["tolerance-cloud", "transmission-error"])
def test_pages_of_a_straight_undercut_pair(name: str) -> None:
    """Line contact has no study of tolerances, and edge contact has large transmission errors."""
    recipe = recipe_of(name)
    data = recipe.compute(straight_undercut())
    page = recipe.drawn(data, of_width(90.0)).page
    assert faults(page) == []
    if name == "tolerance-cloud":
        assert not page.legends
        assert "mountings" not in page.note
        assert [axes.axison for axes in page.axes if axes.get_title("left")] == [False, False]
        assert words(page).count("errors leave contact on edges only") == 2
        assert recipe.drawn(data, of_size((1600, 1200))).page.legends == []


def test_faults_are_seen() -> None:
    """The test of pages reports text that overlaps, is cut off or too small."""
    recipe = recipe_of("sliding")
    page = recipe.drawn(recipe.compute(TABLE), in_print(190.0)).page
    assert faults(page) == []
    title = page.texts[0]
    place = title.get_position()
    for move in ((place[0] - 0.1, place[1]), (place[0], place[1] - 0.1)):
        title.set_position(move)
        assert faults(page)
    title.set_position(place)
    title.set_fontsize(5.9 / PAPER_INCHES_PER_INCH)
    assert len(faults(page)) == 1


def test_indices_have_six_points() -> None:
    recipe = recipe_of("fig-09")
    page = recipe.drawn(recipe.compute(TABLE), in_print(90.0)).page
    indexed: list[Any] = page.findobj(lambda one: isinstance(one, Text) and "$a_1$" in one.get_text())
    sizes = [float(text.get_fontsize()) * PAPER_INCHES_PER_INCH for text in indexed]
    assert min(sizes) * 0.7 > 6.0  # 0.7 is Matplotlib's for indices


def test_long_entries_of_a_legend_are_broken() -> None:
    page, _, _ = theme.new_page(in_print(90.0), "title", "", "")
    page.add_axes((0.1, 0.3, 0.8, 0.4))
    theme.legend(page, [Line2D([], [], label=12 * "entry " + "end")], 4)
    typeset.finish_page(page)
    assert faults(page) == []


def test_words_beside_places_are_moved_apart() -> None:
    page, _, _ = theme.new_page(of_size((800, 600)), "title", "", "")
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0))
    first, second = (theme.label_point(axes, (0.5, 0.5), words, (0.0, 0.0)) for words in ("first", "second"))
    edge = theme.label_point(axes, (1.0, 0.2), "at the edge", (0.0, 0.0))
    typeset.finish_page(page)
    one, other = first.get_window_extent(), second.get_window_extent()
    assert not one.overlaps(other)
    assert abs(one.y0 - other.y0) < 2.5 * one.height
    assert edge.get_window_extent().x1 <= 800.0


@pytest.mark.parametrize(
    ("count", "width", "columns"), [(4, 16.0, 2), (4, 12.0, 2), (4, 8.0, 1), (5, 22.0, 3)]
)
def test_cells_fill_the_page(count: int, width: float, columns: int) -> None:
    """Panels keep their distances, end at the margins, and need as few columns as possible for the fewest
    rows."""
    cells = PanelRows(left=1.0, right=0.5, across=0.8, down=0.6, most=4, least=4.0)
    layout = PageLayout(width, 9.0, 100.0)
    assert cells.columns(layout, count) == columns
    boxes = np.array(cells.boxes(layout, count, 9.0, 0.1, 0.9)) * (width, 9.0, width, 9.0)
    left, bottom, wide, high = boxes[:columns].T
    np.testing.assert_allclose(left[0], 1.0)
    np.testing.assert_allclose(left[-1] + wide[-1], width - 0.5)
    np.testing.assert_allclose(np.diff(left), wide[:-1] + 0.8)
    np.testing.assert_allclose(bottom + high, 8.1)
    rows = -(-count // columns)
    np.testing.assert_allclose(boxes[-1, 1], 0.9)
    np.testing.assert_allclose(cells.tall(layout, count, float(high[0])), 7.2)
    assert rows == np.unique(boxes[:, 1].round(9)).size


def test_files_have_their_true_size(tmp_path: Path) -> None:
    for form in ("png", "pdf", "svg"):
        arguments = ["--only", "sliding", "--width-mm", "90", "--format", form, "--out", str(tmp_path)]
        done = CliRunner().invoke(main, arguments)
        assert done.exit_code == 0, done.output
    with Image.open(tmp_path / "sliding.png") as image:
        assert image.width == round(90.0 / 25.4 * 300.0)
        assert image.info["dpi"] == pytest.approx((300.0, 300.0), abs=0.02)
        height_mm = image.height / 300.0 * 25.4
    pdf = (tmp_path / "sliding.pdf").read_bytes()
    assert b"/CIDFontType2" in pdf
    assert b"/Type3" not in pdf
    box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", pdf)
    svg = (tmp_path / "sliding.svg").read_bytes()
    size = re.search(rb'width="([\d.]+)pt" height="([\d.]+)pt"', svg)
    for found in (box, size):
        assert found
        sides = [float(side) / 72.0 * 25.4 for side in found.groups()]
        assert sides == pytest.approx([90.0, height_mm], abs=0.05)
    assert b">pinion roll (deg)</text>" in svg


def test_lines_of_a_pdf_reach_its_edges() -> None:
    """Lines are clipped to the page as laid out, not to the smaller page of the file."""
    page, _, _ = theme.new_page(of_width(90.0), "", "", "")
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    page.patch.set_visible(False)  # it is not clipped
    axes.plot([0.0, 1.0], [0.0, 1.0])
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    with theme.style(), matplotlib.rc_context({"pdf.compression": 0}):
        pdf = files.file_of(page, "pdf")
    ends = [[float(number) for number in line] for line in re.findall(rb"([\d.]+) ([\d.]+) l\n", pdf)]
    assert max(ends) == pytest.approx(72.0 * page.get_size_inches(), abs=0.01)


def test_a_plain_page_leaves_its_words_to_a_file(tmp_path: Path) -> None:
    texts = []
    for plain in (False, True):
        recipe = recipe_of("fig-02")
        page = recipe.drawn(recipe.compute(TABLE), in_print(90.0, plain)).page
        texts.append(" ".join(text.get_text() for text in page.findobj(Text)))
    assert "Fig. 2" in texts[0]
    assert "Fig. 2" not in texts[1]
    arguments = ["--only", "fig-02", "--plain", "--size", "400x300", "--out", str(tmp_path)]
    assert CliRunner().invoke(main, arguments).exit_code == 0
    words = (tmp_path / "fig-02.txt").read_text(encoding="utf-8")
    assert words.startswith("Fig. 2")
    assert "parabola" in words
    assert "$" not in words
    assert list(csv.reader(io.StringIO((tmp_path / "fig-02.csv").read_text(encoding="utf-8"))))


def test_formulas_are_spelled_in_a_file_of_words() -> None:
    spelled = theme.spelled("$a_1$ = 0.001 mm$^{\u22121}$, $\\delta$ = 15 deg")
    assert spelled == "a1 = 0.001 mm\u207b\u00b9, \u03b4 = 15 deg"
    assert theme.spelled("$y_a = a_j l_j^2$") == "ya = aj lj\u00b2"
    assert theme.spelled("5\u00b7$10^{\u221212}$ mm") == "5\u00b710\u207b\u00b9\u00b2 mm"
