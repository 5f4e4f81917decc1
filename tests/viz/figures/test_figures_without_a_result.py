"""Figures of designs without a result are drawn with the reason."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from beveloid_geom import Design, Errors, builtin_design
from beveloid_viz.figures.results import (
    parabola_map as fig_map,
    tolerance_cloud as fig_cloud,
)

from ..pages import drawn, words

TABLE = builtin_design()
OVERLAPPING = TABLE.with_parabola(pinion=0.01)
# Undercut leaves nothing of the pinion's flank in a part of the face.
UNDERCUT = replace(TABLE, pinion=replace(TABLE.pinion, profile_shift=-2.5))
ASTRAY = TABLE.with_errors(Errors(offset=20.0))
MAPS = ("map-parabola",)
REASONS: list[tuple[Design, dict[str, str]]] = [
    (
        UNDERCUT,
        {
            "transmission-error": "undercut",
            "modifications": "undercut",
            "posed-pair": "undercut",
            "meshed-tooth": "undercut",
        },
    ),
    (
        TABLE.with_parabola(pinion=-0.01),
        {"sensitivity": "+2.55"},
    ),
    (
        OVERLAPPING,
        dict.fromkeys(("separation", "transmission-error", "pattern", "meshed-tooth"), "rounds overlap"),
    ),
    (
        ASTRAY,
        {
            **dict.fromkeys(MAPS, ""),
            "sensitivity": "right flanks: no path of contact, the path does not meet the flanks",
            "tolerance-cloud": "no mounting has a path on the flanks",
        },
    ),
    (
        replace(TABLE, pair=replace(TABLE.pair, offset=0.04)),
        {
            "sensitivity": "no path of contact",
            "tolerance-cloud": "no mounting has a path on the flanks",
        },
    ),
    (
        TABLE.with_parabola(0.0005, 0.0005),
        {
            "map-parabola": "",
            "sensitivity": "no mid-roll, the roll is not monotonic along the path",
        },
    ),
    (
        TABLE.with_parabola(pinion=0.03),
        {
            "sensitivity": "no path of contact",
            "tolerance-cloud": "no drawing: the flank does not reach the tip",
        },
    ),
    (
        replace(TABLE, pair=replace(TABLE.pair, shaft_angle=0.1745)),
        dict.fromkeys(MAPS, "no cell has a path"),
    ),
    (replace(TABLE, pair=replace(TABLE.pair, pinion_mounting=230.0)), dict.fromkeys(MAPS, "")),
]


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    few: list[tuple[Any, dict[str, Any]]] = [
        (fig_cloud, {"MOUNTINGS": 20, "PATHS_DRAWN": 20, "CYCLE_MOUNTINGS": 2}),
        (fig_map, {"INTERVAL_COUNT": 2}),
    ]
    for module, values in few:
        for name, value in values.items():
            monkeypatch.setattr(module, name, value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("design", "name", "reason"),
    [(design, name, reason) for design, reasons in REASONS for name, reason in reasons.items()],
)
def test_the_reason_is_on_the_page(design: Design, name: str, reason: str) -> None:
    page, rows = drawn(name, design)
    assert reason in words(page), words(page)
    assert rows or name in ("meshed-tooth", "separation")
    if name in MAPS:
        assert ("no cell has a path" in words(page)) is all(row["status"] != "solved" for row in rows)
        assert len(rows) >= 9


def test_without_contact_no_figure_claims_one() -> None:
    page, _ = drawn("separation", TABLE.with_parabola(pinion=0.01, gear=0.01))
    assert "Right flanks; pinion (top)" in words(page)
