"""Figures of designs without a result are drawn with the reason."""

from __future__ import annotations

from dataclasses import replace

import pytest

from beveloid_geom import Design, Errors, builtin_design
from beveloid_viz.components import panels, viewpoint
from beveloid_viz.figures.results import parabola_map as fig_map, tolerance_cloud as fig_cloud
from beveloid_viz.rendering import theme
from beveloid_viz.rendering.layout import of_size

from ..pages import drawn, words

TABLE = builtin_design()
# Undercut leaves nothing of the pinion's flank in a part of the face.
UNDERCUT = replace(TABLE, pinion=replace(TABLE.pinion, profile_shift=-2.5))
NO_MOUNTING = "no mounting has a path on the flanks"
REASONS: list[tuple[Design, dict[str, str]]] = [
    (
        UNDERCUT,
        dict.fromkeys(("transmission-error", "modifications", "posed-pair", "meshed-tooth"), "undercut"),
    ),
    (TABLE.with_parabola(pinion=-0.01), {"sensitivity": "+2.55"}),
    (
        TABLE.with_parabola(pinion=0.01),
        dict.fromkeys(("separation", "transmission-error", "pattern", "meshed-tooth"), "rounds overlap"),
    ),
    (
        TABLE.with_errors(Errors(offset=20.0)),
        {
            "map-parabola": "",
            "sensitivity": "right flanks: no path of contact, the path does not meet the flanks",
            "tolerance-cloud": NO_MOUNTING,
        },
    ),
    (
        replace(TABLE, pair=replace(TABLE.pair, offset=0.04)),
        {"sensitivity": "no path of contact", "tolerance-cloud": NO_MOUNTING},
    ),
    (
        TABLE.with_parabola(0.0005, 0.0005),
        {"map-parabola": "", "sensitivity": "no mid-roll, the roll is not monotonic along the path"},
    ),
    (
        TABLE.with_parabola(pinion=0.03),
        {
            "sensitivity": "no path of contact",
            "tolerance-cloud": "no drawing: the flank does not reach the tip",
        },
    ),
    (replace(TABLE, pair=replace(TABLE.pair, shaft_angle=0.1745)), {"map-parabola": "no cell has a path"}),
    (replace(TABLE, pair=replace(TABLE.pair, pinion_mounting=230.0)), {"map-parabola": ""}),
]


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fig_map, "INTERVAL_COUNT", 2)
    for name, value in {"MOUNTINGS": 20, "PATHS_DRAWN": 20, "CYCLE_MOUNTINGS": 2}.items():
        monkeypatch.setattr(fig_cloud, name, value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("design", "name", "reason"),
    [(design, name, reason) for design, reasons in REASONS for name, reason in reasons.items()],
)
def test_the_reason_is_on_the_page(design: Design, name: str, reason: str) -> None:
    page, rows = drawn(name, design)
    assert reason in words(page), words(page)
    assert rows or name in ("meshed-tooth", "separation")
    if name == "map-parabola":
        assert ("no cell has a path" in words(page)) is all(row["status"] != "solved" for row in rows)
        assert len(rows) >= 9


def test_without_contact_no_figure_claims_one() -> None:
    page, _ = drawn("separation", TABLE.with_parabola(pinion=0.01, gear=0.01))
    assert "Right flanks; pinion (top)" in words(page)


def test_reason_of_a_flank_that_cannot_be_drawn() -> None:
    view = viewpoint.flank_view(TABLE.pinion, "right")
    with theme.style():
        page, *_ = theme.new_page(of_size((400, 300)), "title", "", "")
        box = theme.place(page, 0.0, 0.0, 1.0, 1.0)
        assert panels.draw_flank(page, box, TABLE.with_parabola(pinion=0.3), 0, view, (), 10.0) is None
    assert "no drawing: the flanks cannot be cut" in words(page)
