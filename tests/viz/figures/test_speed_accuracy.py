"""The figure of speed against accuracy, for designs on which methods fail too: nothing overprinted, nothing
left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from typing import Any

import pytest
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from beveloid_geom import builtin_design
from beveloid_geom.studies import comparison
from beveloid_geom.studies.comparison import Row
from beveloid_viz.figures.methods import speed_accuracy as fig_speed
from beveloid_viz.stage.scene import Size
from beveloid_viz.stage.theme import Page

from ..pages import page_of, words

NAN = float("nan")
SETTINGS: Any = comparison.Settings
COMPARE: Any = comparison.compare
"""Without their types, for input of wrong ones."""
KINDS = {
    **dict.fromkeys(("mesh alone", "mesh, polished"), ("tolerance", (0.1, 0.01, 0.0003))),
    **{f"five equations, {start}": ("xtol", (1e-1, 1e-4, 1e-14)) for start in ("cold", "warm")},
    "Newton on F": ("iterations", (0, 1, 2, 3)),
    **{f"one equation, {way}": ("batch", (1, 100, 100_000)) for way in ("path", "given l1")},
}


def row(method: str, kind: str, value: float, seconds: float, error: float, status: str = "solved") -> Row:
    return Row(method, kind, value, error, error, seconds, 1e-3, status)


def case_of(shift: float, *lost: str) -> fig_speed.SpeedCase:
    """Every method with its settings; all curves within `shift` decades of each other, some not found."""
    rows = []
    for place, (method, (kind, values)) in enumerate(KINDS.items()):
        for number, value in enumerate(values):
            seconds = 1e-4 * 10.0 ** (shift * (place - 3.0) + 0.15 * number)
            if method in lost:
                rows.append(row(method, kind, value, NAN, NAN, "2 of 5 positions not found"))
            else:
                error = 1e-12 if kind == "batch" else 10.0 ** (2.0 - 6.0 * number)
                rows.append(row(method, kind, value, seconds, error))
    return fig_speed.SpeedCase("right", (0.001, -0.001), tuple(rows))


def drawn(data: tuple[fig_speed.SpeedCase, ...], size: Size) -> Page:
    return page_of(fig_speed.draw, data, size)


def boxes(axes: Axes) -> list[Bbox]:
    return [text.get_window_extent() for text in axes.texts]


def overprinted(axes: Axes) -> list[str]:
    """What lies over another text, over a curve, or outside."""
    pairs = combinations(zip(axes.texts, boxes(axes), strict=True), 2)
    found = [text.get_text() for (text, one), (_, other) in pairs if one.overlaps(other)]
    for text, box in zip(axes.texts, boxes(axes), strict=True):
        for line in axes.lines:
            path = line.get_transform().transform_path(line.get_path())
            if path.intersects_bbox(box, filled=False):
                found.append(f"{text.get_text()} over {line.get_color()}")
        room = axes.get_window_extent().padded(1.0)
        if not (room.contains(box.x0, box.y0) and room.contains(box.x1, box.y1)):
            found.append(f"{text.get_text()} outside")
    return found


@pytest.mark.parametrize("size", [(1600, 1200), (1200, 900)])
@pytest.mark.parametrize("shift", [0.0, 0.05, 0.2, 0.5])
def test_no_label_is_overprinted(shift: float, size: Size) -> None:
    page = drawn((case_of(shift),) * 4, size)
    for axes in page.axes:
        assert overprinted(axes) == []
    written = {text.get_text() for text in page.axes[2].texts}
    assert len(written) >= 3, written  # room for some there always is


def test_the_check_of_labels_can_fail() -> None:
    page = drawn((case_of(0.2),) * 4, (800, 600))
    axes = page.axes[2]
    axes.text(1e-4, 1e-2, "in the way of curves")
    axes.text(1e-4, 1e-2, "twice")
    assert len(overprinted(axes)) >= 2


def test_what_failed_is_named_once_below_the_panels() -> None:
    lost = ("mesh, polished", "Newton on F", "one equation, given l1")
    data = (case_of(0.2), case_of(0.2, *lost), *(case_of(0.2),) * 2)
    page = drawn(data, (1200, 900))
    named = "(b) mesh, then polish (all); one equation, Newton (all); one equation, l1 given (all)."
    assert words(page).count(named) == 1
    assert words(page).count("Not found at") == 1
    assert not any("ot found" in text.get_text() for axes in page.axes for text in axes.texts)
    assert fig_speed.failures((case_of(0.2),) * 4) == ""


def test_methods_that_never_get_there_are_named() -> None:
    """Also the one that found all its positions, but none of them well."""
    coarse = case_of(0.2, "five equations, warm")
    rows = [replace(r, error_mm=1e-3) if r.method == "mesh, polished" else r for r in coarse.rows]
    text = fig_speed.finding((replace(coarse, rows=tuple(rows)),))
    assert "a polished mesh, the five equations: never under 1e-9 mm" in text


@pytest.mark.parametrize(
    ("turns", "said"),
    [
        ((200.0, 1e-9, 1e-9, 1e-9), "1 Newton step does"),
        ((200.0, 3.0, 1e-9, 1e-9), "2 Newton steps do"),
        ((200.0, 3.0, 1.0, 1.0), "Newton does not get there in 3 steps"),
        ((1e-9, 1e-9, 1e-9, 1e-9), ""),
    ],
)
def test_newton_steps_count_until_the_rolls_are_exact_too(turns: tuple[float, ...], said: str) -> None:
    """Without parabola the point is exact before any step, and the rolls are not."""
    case = case_of(0.2)
    steps = [row("Newton on F", "iterations", n, 1e-6, 1e-13) for n in range(len(turns))]
    exact = [replace(r, transmission_error_arcsec=turn) for r, turn in zip(steps, turns, strict=True)]
    rows = (*(r for r in case.rows if not r.method.startswith("Newton")), *exact)
    text = fig_speed.finding((replace(case, rows=rows),))
    assert said in text
    assert "0 Newton" not in text
    assert ("Newton" in text) is bool(said)


def test_panels_hold_every_mark() -> None:
    far = replace(case_of(0.2).rows[0], seconds_per_position=3.0, error_mm=1e6)
    data = (replace(case_of(0.2), rows=(far, *case_of(0.2).rows)), *(case_of(0.2),) * 3)
    for axes in drawn(data, (800, 600)).axes[:4]:
        assert axes.get_xlim()[1] > 3.0
        assert axes.get_ylim()[1] > 1e6


@pytest.mark.parametrize(
    ("wrong", "error", "said"),
    [
        (lambda: SETTINGS(batches=(0,)), ValueError, "batches must be at least 1, got 0"),
        (lambda: SETTINGS(batches=7), TypeError, "batches must be a tuple of numbers, got 7"),
        (lambda: SETTINGS(run="7"), TypeError, "run must be whole numbers, got '7'"),
        (lambda: SETTINGS(iterations=(1.5,)), TypeError, "iterations must be whole numbers, got 1.5"),
        (lambda: SETTINGS(tolerances=(NAN,)), ValueError, "tolerances must be finite and greater than 0"),
        (lambda: SETTINGS(xtols="1e-3"), TypeError, "xtols must be a tuple of numbers"),
        (lambda: COMPARE("design"), TypeError, "design must be a Design, got str"),
        (lambda: COMPARE(builtin_design(), "right", 3), TypeError, "settings must be Settings"),
    ],
)
def test_wrong_input_has_one_clear_line(
    wrong: Callable[[], object], error: type[Exception], said: str
) -> None:
    with pytest.raises(error) as caught:
        wrong()
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
