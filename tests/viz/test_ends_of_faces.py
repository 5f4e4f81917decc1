"""Figures and page name the ends of a face by size for both signs of the cone angle."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from beveloid_geom import Design, builtin_design
from beveloid_geom.design.text import design_text
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_viz.components.viewpoint import flank_view
from beveloid_viz.report.cli import main
from beveloid_viz.report.view_data import view_data
from tests.symmetry import exchanged

from .pages import drawn, words

PINION_NARROWS, GEAR_NARROWS = exchanged(builtin_design("anti-backlash")), builtin_design("anti-backlash")


@pytest.mark.parametrize("design", [PINION_NARROWS, GEAR_NARROWS, builtin_design("awd-transfer")])
def test_the_larger_end_of_a_drawn_flank_is_its_heel(design: Design) -> None:
    drawn_ends = []
    for member in design.members:
        half = 0.5 * float(member.face_width)
        back, front = (float(tip_radius(member, z)) for z in (-half, half))
        view = flank_view(member, "right")
        assert view is not None
        expected = ("toe", "heel") if back < front else ("heel", "toe")
        expected = ("back", "front") if back == front else expected
        assert view.ends == expected
        assert view.marks[1, 0, 1] < view.marks[1, 2, 1]  # drawn lower: the end at -z
        drawn_ends.append(view.ends)
    assert [tuple(member["ends"]) for member in view_data(design)["members"]] == drawn_ends


def test_words_of_a_figure_of_a_pinion_that_narrows() -> None:
    """The figure names the ends by size: the path of convex flanks runs from the small end at +z to the large
    end. The CSV file contains the codes."""
    page, rows = drawn("fig-08", PINION_NARROWS, (1000, 750))
    assert "pinion toe \u2192 pinion heel" in words(page)
    assert {(row["enters_at"], row["leaves_at"]) for row in rows} >= {("pinion heel", "pinion toe")}


def test_the_page_has_the_larger_tip_under_the_heel(tmp_path: Path) -> None:
    design, out = tmp_path / "narrows.toml", tmp_path / "page.html"
    design.write_text(design_text(PINION_NARROWS), encoding="utf-8")
    assert CliRunner().invoke(main, [str(design), "--cases", "20", "--out", str(out)]).exit_code == 0
    page = re.sub(r"<script.*?</script>|<svg.*?</svg>", "", out.read_text(encoding="utf-8"), flags=re.DOTALL)
    drawing = page.partition("For the drawing")[2].partition("</section>")[0]
    tables = re.findall(r"<table.*?</table>", drawing, flags=re.DOTALL)
    for table, order in zip(tables, (["heel", "middle", "toe"], ["toe", "middle", "heel"]), strict=True):
        heads = [re.sub("<.*?>", "", cell) for cell in re.findall(r"<th scope=\"col\">.*?</th>", table)]
        assert heads[1:] == order
        row = re.search(r"tip diameter.*?</tr>", table, flags=re.DOTALL)
        assert row is not None
        tips = [float(x) for x in re.findall(r"<span class=\"n\".*?>([\d.]+)</span>", row[0])]
        assert heads[1:][int(np.argmax(tips))] == "heel"
    assert "x from heel (\u22121) to toe (1)" in page
