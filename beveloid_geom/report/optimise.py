"""The parabola coefficients found for an aim."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from ..analysis.edges import Operation
from ..analysis.optimise import Aim, Optimum, Paths
from ..design.model import Design
from ..findings.backlash import backlash_data
from ..findings.remarks import remarks_data
from .columns import ARCSEC, label, number
from .path import ContactReport, contact_report
from .result import Rows, by_columns
from .words import error_words, head_data, head_lines, line, remark_lines

POINTS = 21
"""Positions of the path that are certified."""
WIDTH = 36
"""Of the names of what is compared, in a text."""
FIGURES = {
    "shift": "shift",
    "contact_ratio": "contact_ratio",
    "centre": "pinion_z_middle",
    "peak_to_peak": "peak_to_peak",
}
"""What is compared of the path, and its column."""


@dataclass(frozen=True, eq=False)
class OptimumReport:
    """The `optimum` of a single design for an `aim` on the path of one flank pair."""

    name: str
    design: Design
    aim: Aim
    flank: str
    optimum: Optimum
    failure: str | None = None

    @property
    def contact(self) -> ContactReport:
        """The path of contact with the coefficients found."""
        return contact_report(self.name, self.optimum.design, self.flank, POINTS)

    def data(self) -> dict[str, Any]:
        """Give the coefficients found; None for a condition that was not asked for."""
        found, contact = self.optimum, self.contact
        data = {
            **head_data(self.name, self.design, self.flank),
            "aim": asdict(self.aim),
            "parabola": {"pinion": found.pinion_parabola, "gear": found.gear_parabola},
            "found": _figures(found.found, found.found_operation),
            "given": _figures(found.given, found.given_operation),
            **backlash_data(found.design),
            **remarks_data(contact.remarks),
        }
        if contact.certificate is not None:
            data["certified"] = {"first_contact": contact.certified_count, "positions": POINTS}
        return data

    def rows(self) -> Rows:
        """Give a row for the coefficients found and one for those given."""
        found, given = self.optimum, (float(member.tool.parabola) for member in self.design.members)
        figures = (
            _figures(found.found, found.found_operation),
            _figures(found.given, found.given_operation),
        )
        names = ("design", "parabola_pinion", "parabola_gear", *(FIGURES.get(key, key) for key in figures[0]))
        coefficients = ("found", found.pinion_parabola, found.gear_parabola), ("given", *given)
        rows = [(*head, *values.values()) for head, values in zip(coefficients, figures, strict=True)]
        return by_columns(names, rows)

    def summary(self) -> str:
        """Write aim, coefficients, and the figures found beside those given."""
        found, contact = self.optimum, self.contact
        text = f"Parabola coefficients for {self.name}, {self.flank} flanks: least shift under errors\n"
        text += head_lines(self.design) + line("aim", _aim_words(self.aim))
        text += line("errors of the aim", error_words(self.aim.errors))
        coefficients = found.pinion_parabola, found.gear_parabola
        text += line("coefficients", "pinion {:.6g} 1/mm, gear {:.6g} 1/mm".format(*coefficients))
        if contact.certificate is not None:
            count = f"{contact.certified_count} of {POINTS} positions"
            text += line("certified", f"{count}: nothing on this side touches earlier")
        text += line("as mounted", f"backlash {contact.backlash.line}") + remark_lines(contact.remarks)
        text += f"\n{'':<{WIDTH}}{'found':>14}{'as given':>14}\n"
        given = _figures(found.given, found.given_operation)
        for key, value in _figures(found.found, found.found_operation).items():
            text += f"{label(key):<{WIDTH}}{number(key, value, 14)}{number(key, given[key], 14)}\n"
        return text


def _figures(paths: Paths, operation: Operation) -> dict[str, float]:
    """Give what is compared, by name."""
    return {key: float(getattr(paths, key)) for key in FIGURES} | asdict(operation)


def _aim_words(aim: Aim) -> str:
    words = f"contact ratio at least {aim.contact_ratio:g}, middle within {aim.off_centre:g} mm of mid-face"
    if math.isfinite(aim.peak_to_peak):
        limit = ARCSEC * aim.peak_to_peak
        words += f", transmission error at most {limit:g} arcsec peak to peak"
    words += "" if aim.edges else ", no edge carries, with these errors or without"
    bounds = "; pinion {:g} to {:g}, gear {:g} to {:g} 1/mm".format(*aim.pinion_parabola, *aim.gear_parabola)
    return words + bounds
