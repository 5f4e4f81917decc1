"""Measured points in a figure: `render-figures --measured`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from beveloid_geom import builtin_design
from beveloid_geom.report.workshop.grid import DeviationReport, GridOrigin
from beveloid_geom.workshop.grid import measuring_grid
from beveloid_geom.workshop.measured import deviations_of
from beveloid_viz.cli import main
from beveloid_viz.figures.results import deviations
from beveloid_viz.rendering import theme

from ...cli.running import refused
from ..pages import page_of, table_in, words
from ..test_print import WIDTHS, assert_printable, in_print

ROWS, COLUMNS = 3, 5


def report(size: float = 0.01) -> DeviationReport:
    """Return deviations of the gear: a wave along both flanks with one larger point."""
    grid = measuring_grid(builtin_design().gear, ROWS, COLUMNS)
    wave = size * np.sin(np.arange(grid.l.size)).reshape(grid.l.shape)
    wave[1, -1, 0] = -1.5 * size
    point = grid.point + wave[..., None] * grid.normal
    return DeviationReport(GridOrigin("mine", "gear", "10 %"), deviations_of(grid, point))


@pytest.mark.parametrize("size", [1e-5, 0.01, 0.3])
def test_sticks_are_as_long_as_the_deviations(size: float) -> None:
    """The length of each stick is proportional to the deviation, with one scale for both panels. Sticks of
    missing metal are red, and each number is printed."""
    found = report(size)
    page = page_of(deviations.draw, found, (1600, 1200))
    scales = set()
    for axes, values in zip(page.axes, found.result.deviation, strict=True):
        sticks = [line for line in axes.lines if line.get_linewidth() == 2.4]
        heights = np.array([np.ptp(line.get_ydata()) for line in sticks])
        scale = np.abs(found.result.deviation).max() / 0.45
        np.testing.assert_allclose(heights * scale, np.abs(values).ravel(), rtol=1e-9, atol=1e-15)
        red = [line.get_color() == theme.VERMILLION for line in sticks]
        assert red == (values.ravel() <= 0.0).tolist()
        scales.add((axes.get_ylim(), axes.bbox.height))
        shown = {text.get_text() for text in axes.texts}
        assert {theme.signed(1e3 * value, 1) for value in values.ravel().tolist()} <= shown
    assert len(scales) == 1
    assert "Gear, 45 teeth" in words(page)


def test_long_numbers_are_apart_and_clear_of_the_grid() -> None:
    """Numbers of a grid of 5 x 9 points touch neither each other nor the horizontal lines of the grid."""
    grid = measuring_grid(builtin_design().gear, 5, 9)
    found = DeviationReport(
        GridOrigin("mine", "gear", ""), deviations_of(grid, grid.point + 0.01 * grid.normal)
    )
    axes = page_of(deviations.draw, found, (1600, 1200)).axes[0]
    boxes = [text.get_window_extent().padded(1.0) for text in axes.texts if text.get_text() == "+10.0"]
    assert len(boxes) == 25
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:k])
        low, high = axes.transData.inverted().transform(box)[:, 1]
        assert not any(low < y < high for y in np.linspace(-1.0, 1.0, 5))


@pytest.mark.parametrize("width", WIDTHS)
def test_the_page_is_printable(width: float) -> None:
    assert_printable(deviations.RECIPES["deviations"].drawn(report(), in_print(width)).page, width)


def test_the_command_draws_a_file(tmp_path: Path) -> None:
    """The numbers are those of the command `grid`; a wrong file is refused."""
    found, path, out = report(), tmp_path / "m.txt", tmp_path / "out"
    points = found.result.point.reshape(-1, 3).tolist()
    path.write_text("\n".join(" ".join(map(repr, point)) for point in points), encoding="utf-8")
    asked = ["--measured", str(path), "--rows", "3", "--columns", "5", "--size", "600x450", "--out"]
    done = CliRunner().invoke(main, [*asked, str(out), "--member", "gear"])
    assert done.exit_code == 0, done.output
    table = table_in(out / "deviations.csv")
    np.testing.assert_allclose(
        [float(row["deviation_mm"]) for row in table], found.result.deviation.ravel(), atol=1e-12
    )
    assert (out / "deviations.png").stat().st_size > 10_000
    other = tmp_path / "none"
    assert f"{path}: has " in refused(*asked, other, "--member", "pinion", program=main)
    assert not other.exists()
    refused(*asked, out, "--only", "fig-09", program=main)
