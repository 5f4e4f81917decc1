"""The figure of picture differences over the mesh tolerance: what it compares, and that it says why not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from beveloid_viz.figures import FIGURES
from beveloid_viz.figures.methods import picture_density as fig_density, picture_differences as density
from beveloid_viz.figures.methods.picture_differences import NOTICEABLE, Difference, Series, View
from beveloid_viz.figures.results import posed_pair as fig_posed
from beveloid_viz.parts import panels
from beveloid_viz.parts.recipe import Drawing
from beveloid_viz.stage import theme
from beveloid_viz.stage.opengl import require_opengl
from beveloid_viz.stage.scene import MESH_PX, Camera, Scene, Size, Tube

from beveloid_geom.design.file import builtin_design
from beveloid_geom.design.model import Design, Errors

SMALL: dict[Callable[[Design, Size], View], Size] = {
    density.pair_view: (332, 253),
    density.flank_view: (240, 360),
    density.teeth_view: (168, 225),
}
"""The pictures at 0.4 of the figure's size, but for the flank, which is small."""
TOLERANCES = (2.0, 0.2, 0.05)
STATED = 2 * NOTICEABLE
"""Levels by which the worst window of a picture may differ at the default."""


@pytest.fixture(scope="module", autouse=True)
def _opengl() -> None:
    require_opengl()


@pytest.fixture(scope="module")
def small() -> tuple[Series, ...]:
    """All pictures of the built-in design, small."""
    views = {name: view_of(builtin_design(), size) for name, (view_of, size) in small_views().items()}
    return tuple(density.measure(name, view, TOLERANCES) for name, view in views.items())


def small_views() -> dict[str, tuple[Callable[[Design, Size], View], Size]]:
    return {name: (view_of, SMALL[view_of]) for name, (view_of, _) in density.VIEWS.items()}


def drawn(data: tuple[Series, ...]) -> Drawing:
    with theme.style():
        return fig_density.draw(data, (800, 600))


def words_of(drawing: Drawing) -> str:
    page = drawing.page
    texts = (*page.texts, *(text for axes in page.axes for text in axes.texts))
    return " ".join(" ".join(text.get_text() for text in texts).split())


def test_it_is_among_the_figures() -> None:
    figure = next(figure for figure in FIGURES if figure.name == "picture-density")
    assert figure.recipe() is fig_density.RECIPES["picture-density"]
    assert {view_of for view_of, _ in density.VIEWS.values()} == set(SMALL)


def test_differences_fall_with_the_tolerance(small: tuple[Series, ...]) -> None:
    for series in small:
        pixels = [shot.pixels for shot in series.shots]
        assert pixels == sorted(pixels, reverse=True)
        triangles = [shot.triangles for shot in series.shots]
        assert triangles == sorted(triangles)
        assert triangles[-1] > triangles[0]
        for measure in ("differing_share", "mean"):
            values = [getattr(shot.difference, measure) for shot in series.shots]
            assert values == sorted(values, reverse=True), (series.name, measure, values)
        coarse, fine = series.shots[0].difference, series.shots[-2].difference
        assert fine.worst_place < 0.4 * coarse.worst_place
        assert fine.noticeable_share < 0.3 * coarse.noticeable_share


def test_the_finest_is_compared_with_itself(small: tuple[Series, ...]) -> None:
    for series in small:
        assert series.shots[-1].difference == Difference(0.0, 0.0, 0.0, 0.0, 0.0)
        assert series.shots[-1].pixels == pytest.approx(0.25 * series.shots[-2].pixels)
        assert all(shot.difference.greatest > 0.0 for shot in series.shots[:-1])


def test_a_picture_is_the_same_when_drawn_again() -> None:
    """Else the differences would be those of drawing."""
    view = density.flank_view(builtin_design(), (120, 180))
    shots = [density.measure("", view, (0.5,)).shots[0] for _ in range(2)]
    assert shots[0].difference == shots[1].difference
    np.testing.assert_array_equal(shots[0].crop, shots[1].crop)


def test_the_default_is_near_what_is_noticed(small: tuple[Series, ...]) -> None:
    for series in small:
        difference = series.shots[series.default].difference
        assert difference.worst_place < STATED, series.name
        assert difference.noticeable_share < 0.015, series.name


def test_the_default_is_that_of_the_figures(small: tuple[Series, ...]) -> None:
    pair, flank, teeth = (series.shots[series.default] for series in small)
    assert pair.pixels == MESH_PX
    assert flank.pixels == panels.OUTLINE_PX
    assert teeth.tolerance == pytest.approx(fig_posed.tolerance_of(builtin_design()))
    assert teeth.tolerance == pytest.approx(fig_posed.EXPORTED)


def test_rows_are_complete(small: tuple[Series, ...]) -> None:
    header, rows = fig_density.rows(small)
    assert tuple(header)[:9] == (
        *("picture", "tolerance_mm", "tolerance_px", "triangles", "sampling_seconds", "render_seconds"),
        *("differing_share", "greatest_difference", "mean_difference"),
    )
    found = list(rows)
    assert all(len(row) == len(header) for row in found)
    assert len(found) == sum(len(series.shots) for series in small)
    assert {row[0] for row in found} == set(density.VIEWS)
    assert np.isfinite(np.array([row[1:-1] for row in found], dtype=float)).all()
    assert header[-1] == "status"
    assert {row[-1] for row in found} == {"drawn"}


def test_every_picture_is_on_the_page_with_its_verdict(small: tuple[Series, ...]) -> None:
    words = words_of(drawn(small))
    for series in small:
        assert series.name in words
        assert " ".join(fig_density.finding(series).split()) in words


@pytest.mark.parametrize(
    ("levels", "suffices"),
    [((20.0, 7.0, 5.0), 2), ((20.0, 5.0, 7.0), None), ((5.0, 7.0, 3.0), 2), ((6.0, 5.0, 4.0), 0)],
)
def test_a_tolerance_suffices_if_all_finer_ones_do(
    small: tuple[Series, ...], levels: tuple[float, ...], suffices: int | None
) -> None:
    flank = small[1]
    shots = [
        replace(shot, difference=replace(shot.difference, worst_place=level))
        for shot, level in zip(flank.shots, levels, strict=False)
    ]
    series = replace(flank, shots=(*shots, flank.shots[-1]), default=1)
    found = fig_density.unseen_from(series)
    assert found is (None if suffices is None else shots[suffices])
    verdict = {None: "no tolerance in (a)", 0: "as does 2 pixels", 2: "too coarse"}[suffices]
    assert verdict in fig_density.finding(series)


def test_worst_place() -> None:
    """Closed form: a straight outline in the middle of a picture, differing along half of it."""
    levels, on_outline = np.zeros((200, 200)), np.zeros((200, 200), dtype=bool)
    on_outline[:, 100] = True
    levels[100:, 100] = 12.0
    assert density.worst_place(levels, on_outline) == pytest.approx(12.0)
    levels[100::2, 100] = 0.0
    assert density.worst_place(levels, on_outline) == pytest.approx(6.0)
    levels[:, 100], levels[100, 50] = 0.0, 200.0
    assert density.worst_place(levels, on_outline) == pytest.approx(200.0 / density.WINDOW**2)
    short = np.zeros((200, 200), dtype=bool)
    short[100, 100 : 100 + density.WINDOW // 2] = True
    levels = np.where(short, 50.0, 0.0)
    assert density.worst_place(levels, short) == 0.0


def test_outlines_are_where_pixels_differ_from_their_neighbours() -> None:
    image = np.full((20, 20, 3), 200, dtype=np.uint8)
    image[:, 10:] = 200 - density.OUTLINE
    assert not density.outlines(image).any()
    image[:, 10:, 1] -= 1
    assert np.flatnonzero(density.outlines(image)[0]).tolist() == [9, 10]


def test_a_moved_ball_is_seen() -> None:
    """A ball that moves by half a pixel: nothing differs far from its outline, and that noticeably."""
    camera = Camera(np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0]), np.zeros(3), 50.0)

    def build(tolerance: float) -> Scene:
        return Scene([Tube(np.array([[tolerance, 0.0, 0.0]]), theme.STEEL, 30.0)], camera)

    coarse, _, finest = density.measure("ball", View((100, 100), 1.0, 0.5, build), (0.01,)).shots
    assert coarse.pixels == 0.5
    assert coarse.difference.worst_place > NOTICEABLE
    assert 0.5 * 100.0 < coarse.difference.greatest < 255.0
    assert 0.0 < coarse.difference.noticeable_share < 3.0 * 2.0 * np.pi * 30.0 / 100.0**2
    assert finest.difference.greatest == 0.0


def test_without_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    """The flank has no path on it, the pair stands at nominal rolls, and no teeth are in mesh."""
    size = SMALL[density.flank_view]
    design = replace(builtin_design(), errors=Errors(offset=20.0))
    assert len(density.flank_view(design, size).build(0.1).items) == 1
    assert len(density.flank_view(builtin_design(), size).build(0.1).items) > 1
    monkeypatch.setattr(density, "VIEWS", small_views())
    data = fig_density.compute(design)
    assert [bool(series.shots) for series in data] == [True, True, False]
    assert data[0].shots[0].difference.greatest > 0.0
    assert "no contact point" in words_of(drawn(data))


@pytest.mark.parametrize(
    ("design", "reasons"),
    [
        (builtin_design().with_parabola(pinion=-0.01), ("undercut from z", "", "undercut from z")),
        (builtin_design().with_parabola(pinion=0.01), ("rounds overlap", "", "rounds overlap")),
    ],
    ids=["undercut", "pointed rack"],
)
def test_without_teeth_the_reason_is_on_the_page(
    design: Design, reasons: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(density, "VIEWS", small_views())
    data = fig_density.compute(design)
    words = words_of(drawn(data))
    for series, reason in zip(data, reasons, strict=True):
        assert bool(series.shots) is not bool(reason)
        assert reason in series.reason
        assert reason in words
    header, lines = fig_density.rows(data)
    rows = list(lines)
    assert all(len(row) == len(header) for row in rows)
    for series in data:
        own = [row for row in rows if row[0] == series.name]
        assert len(own) == max(1, len(series.shots))
        assert {row[-1] for row in own} == {series.reason or "drawn"}


def test_a_page_without_any_picture() -> None:
    words = words_of(drawn(tuple(Series(name, reason=f"no {name}") for name in density.VIEWS)))
    assert all(f"no {name}" in words for name in density.VIEWS)
