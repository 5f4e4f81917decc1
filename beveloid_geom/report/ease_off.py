"""The ease-off of both flanks of a pinion, with its parabolas and without."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.ease_off import EaseOff, ease_off
from ..arrays import FLANK_SIGN
from ..contact.path import path_of_contact
from ..design.model import Design
from ..findings.path import reason_of
from ..status import Status
from .columns import number
from .result import Rows
from .words import head_lines, layout_data, line, status_name

GIVEN, PLAIN = "as_given", "without_parabola"
GRID = ("l", "z", "deviation", "pinion_roll")
"""Numbers of a point."""
POINT = ("flank", "parabola", "profile_place", "face_place", *GRID, "status")
"""Columns of a point."""
LABELS = {
    **{f"{depth}_{end}": f"{depth}, {end}" for depth in ("root", "tip") for end in ("toe", "heel")},
    "mean": "mean",
    "face_slope": "slope along the face",
    "profile_slope": "slope along the profile",
    "face_crowning": "crowning along the face",
    "profile_crowning": "crowning along the profile",
    "twist": "twist",
    "rest": "rms of the rest",
}
"""Words for the corners and coefficients of a text."""


@dataclass(frozen=True, eq=False)
class EaseOffReport:
    """Ease-off of right and left flanks of a single design: `found` by flank and by GIVEN and PLAIN, with its
    parabolas and without; where a pair has no path of contact, the reason why."""

    name: str
    design: Design
    found: dict[tuple[str, str], EaseOff | str]

    @property
    def known(self) -> dict[tuple[str, str], EaseOff]:
        """What was found."""
        return {key: one for key, one in self.found.items() if isinstance(one, EaseOff)}

    @property
    def reason(self) -> str | None:
        """Why the design as given has no path on a flank, None if it has both."""
        return next(
            (one for (_, of), one in self.found.items() if of == GIVEN and isinstance(one, str)), None
        )

    @property
    def failure(self) -> str | None:
        """Why there is no contact."""
        return f"No contact: {self.reason}" if self.reason else None

    def data(self) -> dict[str, Any]:
        """Give grids, corners and coefficients; mm."""
        data = layout_data(self.name, self.design)
        data["parabola"] = {name: getattr(self.design, name).tool.parabola for name in ("pinion", "gear")}
        for (flank, state), one in self.found.items():
            own = {"reason": one} if isinstance(one, str) else _numbers(one)
            data.setdefault(flank, {})[state] = own
        return data | ({"reason": self.reason} if self.reason else {})

    def rows(self) -> Rows:
        """Give the points."""
        tables = [_points(flank, state, one) for (flank, state), one in self.known.items()]
        return {name: [value for table in tables for value in table[name].tolist()] for name in POINT}

    def summary(self) -> str:
        """Write corners and coefficients of both flanks, then how they are meant."""
        text = f"Ease-off of {self.name}: the pinion's flanks against the conjugate of the untrimmed gear\n\n"
        bent = any(float(member.tool.parabola) for member in self.design.members)
        shown = [key for key in self.found if bent or key[1] == GIVEN]
        heads = [f"{flank} flanks" for flank, _ in shown], [state.replace("_", " ") for _, state in shown]
        text += "".join(
            f"{label:30}" + "".join(f"{head:>17}" for head in row) + "\n"
            for label, row in zip(("", "  um"), heads, strict=True)
        )
        sizes = [_sizes(one) if isinstance(one, EaseOff) else {} for one in map(self.found.get, shown)]
        for name, words in LABELS.items():
            values = (own.get(name, np.nan) for own in sizes)
            cells = (f"{'-':>17}" if np.isnan(size) else number("deviation", size, 17) for size in values)
            text += f"  {words:28}" + "".join(cells) + "\n"
        text += "\n" + head_lines(self.design)
        text += line("sign", "positive where the flanks part; they touch at mid-roll of the path, at 0")
        text += line(
            "coefficients", "of 1, x, y, x^2 - 1/3, y^2 - 1/3 and x y; x toe to heel, y root to tip, -1 to 1"
        )
        return text + "".join(line("note", note) for key in shown if (note := self._note(*key)))

    def _note(self, flank: str, state: str) -> str:
        """Say what is not known of a flank."""
        one, lead = self.found[flank, state], f"{flank} flanks, {state.replace('_', ' ')}"
        if isinstance(one, str):
            return f"{lead}: {one}"
        lost = np.count_nonzero(one.status != Status.SOLVED)
        return f"{lead}: the mate has no conjugate at {lost} of {one.status.size} points" if lost else ""


def ease_off_report(name: str, design: Design, grid: tuple[int, int]) -> EaseOffReport:
    """Find the ease-off of a single design; the grid and ValueError as of `ease_off`."""
    designs = {GIVEN: design, PLAIN: design.with_parabola(0.0, 0.0)}
    found: dict[tuple[str, str], EaseOff | str] = {}
    for flank in FLANK_SIGN:
        for state, one in designs.items():
            reason = reason_of(path_of_contact(one, flank, 2))
            found[flank, state] = reason or ease_off(one, flank, grid)
    return EaseOffReport(name, design, found)


def _sizes(one: EaseOff) -> dict[str, float]:
    """Give corners and coefficients, mm."""
    return one.corners | vars(one.second_order)


def _numbers(one: EaseOff) -> dict[str, Any]:
    """Give the entries of one flank in JSON."""
    status = [[status_name(int(code)) for code in row] for row in one.status]
    places = {"profile_place": one.profile, "face_place": one.face}
    grid = {name: getattr(one, name) for name in GRID}
    return {
        **places,
        **grid,
        "status": status,
        "corners": one.corners,
        "second_order": vars(one.second_order),
    }


def _points(flank: str, state: str, one: EaseOff) -> dict[str, Any]:
    """Give the points of one flank."""
    places = np.meshgrid(one.profile, one.face, indexing="ij")
    return {
        "flank": np.full(one.status.size, flank),
        "parabola": np.full(one.status.size, state),
        **{name: place.ravel() for name, place in zip(("profile_place", "face_place"), places, strict=True)},
        **{name: getattr(one, name).ravel() for name in GRID},
        "status": np.array([status_name(int(code)) for code in one.status.ravel()]),
    }
