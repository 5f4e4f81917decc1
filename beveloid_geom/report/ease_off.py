"""Report of `ease-off`: both flanks of the pinion, of the design as given and of the unmodified design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.ease_off import EaseOff, ease_off
from ..arrays import FLANK_SIGN
from ..contact.path import path_of_contact
from ..design.ends import end_names
from ..design.model import Design
from ..findings.path import reason_of
from ..status import Status
from .columns import known_number, labelled_lines
from .result import Report, Rows, flattened, parabola_data, picked, stacked_rows
from .text import head_lines, line

GIVEN, PLAIN = "as_given", "without_parabola"
STATE_WORDS = {GIVEN: "as designed", PLAIN: "unmodified"}
GRID = ("l", "z", "deviation", "pinion_roll")
"""Quantities of a point."""
SECOND_ORDER = {
    "mean": "mean",
    "face_slope": "slope along the face",
    "profile_slope": "slope along the profile",
    "face_crowning": "crowning along the face",
    "profile_crowning": "crowning along the profile",
    "twist": "twist",
    "rest": "rms of the residual",
}
"""Labels of the coefficients of a quadratic surface."""


@dataclass(frozen=True, eq=False)
class EaseOffReport(Report):
    """Ease-off of right and left flanks of a single design.

    `results` contains the ease-off by flank and by GIVEN or PLAIN, or the reason for a missing path of
    contact."""

    results: dict[tuple[str, str], EaseOff | str]

    @property
    def known(self) -> dict[tuple[str, str], EaseOff]:
        """The ease-off of the flanks with a path of contact."""
        return {key: result for key, result in self.results.items() if isinstance(result, EaseOff)}

    @property
    def reason(self) -> str | None:
        """Reason why the design as given has no path on a flank, None if it has both."""
        given = (result for (_, state), result in self.results.items() if state == GIVEN)
        return next((result for result in given if isinstance(result, str)), None)

    @property
    def modified(self) -> bool:
        """Whether a flank has a parabola or a modification."""
        return self.design.unmodified() != self.design

    def values(self) -> dict[str, Any]:
        """Return grids, corners and coefficients; mm."""
        parabolas = {flank: parabola_data(self.design, flank) for flank in FLANK_SIGN}
        flanks: dict[str, Any] = {flank: {"parabola": data["parabola"]} for flank, data in parabolas.items()}
        for (flank, state), result in self.results.items():
            flanks[flank][state] = {"reason": result} if isinstance(result, str) else _numbers(result)
        return {**parabolas["right"], **flanks}

    def rows(self) -> Rows:
        """Return the points."""
        # Columns of a point.
        point = ("flank", "parabola", "profile_place", "face_place", *GRID, "status")
        return stacked_rows([_points(*key, result) for key, result in self.known.items()], point)

    def summary(self) -> str:
        """Return corners and coefficients of both flanks, and their definitions."""
        text = f"Ease-off of {self.name}: distance of the pinion flanks from flanks conjugate to the gear\n\n"
        shown = [key for key in self.results if self.modified or key[1] == GIVEN]
        rows = [("", [f"{flank} flanks" for flank, _ in shown])]
        rows += [("  values in um", [STATE_WORDS[state] for _, state in shown])]
        sizes = [_sizes(self.known[key]) if key in self.known else {} for key in shown]
        ends = dict(zip(("toe", "heel"), end_names(self.design.pinion), strict=True))
        labels = {
            f"{depth}_{end}": f"{depth}, {name}" for depth in ("root", "tip") for end, name in ends.items()
        }
        for name, words in (labels | SECOND_ORDER).items():
            cells = [known_number("deviation", by_name.get(name, np.nan)) for by_name in sizes]
            rows.append((f"  {words}", cells))
        text += labelled_lines(rows, 30, 17) + "\n" + head_lines(self.design)
        if self.modified:
            text += line("unmodified", "without parabolas and modifications")
        text += line("sign", "positive where the flanks are apart; 0 at the point of contact at mid-roll")
        text += line(
            "coefficients",
            "mean to twist are those of 1, x, y, x^2 - 1/3, y^2 - 1/3 and x y; x runs from -1 at the"
            f" {ends['toe']} to 1 at the {ends['heel']}, y from -1 at the root to 1 at the tip",
        )
        return text + "".join(line("note", note) for key in shown if (note := self._note(*key)))

    def _note(self, flank: str, state: str) -> str:
        """Return why the ease-off of a flank, or of some of its points, is unknown."""
        result, lead = self.results[flank, state], f"{flank} flanks, {STATE_WORDS[state]}"
        if isinstance(result, str):
            return f"{lead}: {result}"
        count = np.count_nonzero(result.status != Status.SOLVED)
        return f"{lead}: the mate has no conjugate at {count} of {result.status.size} points" if count else ""


def ease_off_report(name: str, design: Design, grid: tuple[int, int]) -> EaseOffReport:
    """Return the ease-off of a single design; `grid` and ValueError as in `ease_off`."""
    designs = {GIVEN: design, PLAIN: design.unmodified()}
    results: dict[tuple[str, str], EaseOff | str] = {}
    for flank in FLANK_SIGN:
        for state, variant in designs.items():
            reason = reason_of(path_of_contact(variant, flank, 2))
            results[flank, state] = reason or ease_off(variant, flank, grid)
    return EaseOffReport(name, design, results)


def _sizes(result: EaseOff) -> dict[str, float]:
    """Return corners and coefficients by name, mm."""
    return result.corners | vars(result.second_order)


def _numbers(result: EaseOff) -> dict[str, Any]:
    """Return the entries of one flank in JSON."""
    return {
        **{"profile_place": result.profile, "face_place": result.face},
        **picked(result, *GRID, "status", "corners", "second_order"),
    }


def _points(flank: str, state: str, result: EaseOff) -> dict[str, Any]:
    """Return the columns of one flank."""
    profile, face = np.meshgrid(result.profile, result.face, indexing="ij")
    columns = {"profile_place": profile, "face_place": face, **picked(result, *GRID, "status")}
    return {"flank": flank, "parabola": state} | flattened(columns)
