"""What was looked for: parabola coefficients for an aim, and errors that put a path where it is wanted."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..analysis.edges import Operation
from ..analysis.optimise import Aim, Optimum, Paths
from ..analysis.place import Placement, place_path
from ..arrays import FloatArray
from ..design.model import Design
from ..findings.backlash import backlash_data
from ..findings.remarks import remarks_data
from ..pair.mounting import mounting_of
from ..status import PlaceStatus
from .columns import ARCSEC, label, number, scaled
from .path import ContactReport, contact_report
from .result import Rows, by_columns
from .words import (
    SHORT,
    TRADE,
    error_words,
    head_data,
    head_lines,
    line,
    mounted_lines,
    name_in_files,
    remark_lines,
    trade_words,
    unit_of,
)

LEAST = {
    "shift": "least shift under errors",
    "transmission_error": "least error of all teeth under any error",
}
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
        text = f"Parabola coefficients for {self.name}, {self.flank} flanks: {LEAST[self.aim.least]}\n"
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
    words += f", shift at most {aim.shift:g} mm" if math.isfinite(aim.shift) else ""
    words += "" if aim.edges else ", no edge carries, with these errors or without"
    bounds = "; pinion {:g} to {:g}, gear {:g} to {:g} 1/mm".format(*aim.pinion_parabola, *aim.gear_parabola)
    return words + bounds


PLACED = (
    *("z", "l", "off_centre", "contact_ratio", "cycle_peak_to_peak", "edge_share"),
    "normal_backlash",
)
"""Numbers of a mounting, as it runs."""
PLACE_WIDTHS = (7, 12, 12, 10, 9, 8, 12, 10)
"""Characters of the columns of a text."""
DISTANCES = {"pinion_axial": "pinion_mounting", "gear_axial": "gear_mounting"}
"""Mounting distances by the errors that change them."""


@dataclass(frozen=True, eq=False)
class PlaceReport:
    """The mountings `found` of a single design."""

    name: str
    found: Placement

    @property
    def reason(self) -> str | None:
        """Why there is nothing, None if a mounting has a path."""
        none = (self.found.status == PlaceStatus.NO_PATH).all()
        return f"no mounting tried has a path on the {self.found.flank} flanks" if none else None

    @property
    def failure(self) -> str | None:
        """Why there is no contact."""
        return f"No contact: {self.reason}" if self.reason else None

    @property
    def places(self) -> list[dict[str, Any]]:
        """What is known of each place, by name, mm and rad."""
        found, figures = self.found, figures_of(self.found)
        places = []
        for k, code in enumerate(found.status.tolist()):
            place: dict[str, Any] = {"at": found.at[k], "status": name_in_files(PlaceStatus(code))}
            place |= {f"{name}_error": found.errors[k, j] for j, name in enumerate(found.by)}
            place |= {name: values[k] for name, values in distances_of(found).items()}
            place |= {name: figures[name][k] for name in PLACED} | {"jammed": bool(found.jammed[k])}
            place |= {f"exact_{name}_error": found.exact[k, j] for j, name in enumerate(found.by)}
            places.append(place)
        return places

    def data(self) -> dict[str, Any]:
        """Give the places; mm and rad."""
        found = self.found
        data = {
            **head_data(self.name, found.design, found.flank),
            "by": found.by,
            "trade": [TRADE.get(name) for name in found.by],
            "limits": found.limits,
            "wanted_l": found.wanted_l,
            "places": self.places,
        }
        return data | ({"reason": self.reason} if self.reason else {})

    def rows(self) -> Rows:
        """Give the places."""
        places = self.places
        return {name: [place[name] for place in places] for name in places[0]}

    def summary(self) -> str:
        """Write the places, what cannot be reached, and how it is meant."""
        found = self.found
        by = " and ".join(name.replace("_", " ") for name in found.by)
        text = f"Placing the path of {self.name} by {by}, {found.flank} flanks\n\n"
        heads = ["face, %", *(f"{SHORT[name]}, {unit_of(name)}" for name in found.by)]
        heads += ["z, mm", "off, mm", "ratio", "TE, arcsec", "edges, %"]
        text += "".join(f"{head:>{w}}" for head, w in zip(heads, PLACE_WIDTHS, strict=True)) + "  status\n"
        for place in self.places:
            text += "".join(f"{cell:>{w}}" for cell, w in zip(self._cells(place), PLACE_WIDTHS, strict=True))
            text += f"  {place['status'].replace('_', ' ')}\n"
        text += "\n" + mounted_lines(found.design)
        text += line("errors added", ", ".join(trade_words(name) for name in found.by))
        text += line(
            "middle",
            "of the path at mid-roll, on the pinion: its place on the face from the toe, z from mid-face,"
            f" and off l1 = {found.wanted_l:.4f} mm, where it is centred in profile",
        )
        letters = {"pinion_mounting": "dw1", "gear_mounting": "dw2"}
        for k, share in enumerate(found.at):
            distances = [
                (letters[name], z[k]) for name, z in distances_of(found).items() if np.isfinite(z[k])
            ]
            if words := [f"{letter} = {z:.6f} mm" for letter, z in distances]:
                text += line(f"at {100.0 * share:g} %", ", ".join(words))
        return text + "".join(line("note", note) for k in range(found.at.size) for note in self._notes(k))

    def _cells(self, place: dict[str, Any]) -> list[str]:
        """Write the numbers of one place."""
        names = [f"{name}_error" for name in self.found.by]
        cells = [f"{100.0 * place['at']:g}"]
        cells += [f"{scaled(name, place[name]):+.6f}" for name in names]
        cells += [f"{place['z']:z.4f}", f"{place['off_centre']:z.4f}", f"{place['contact_ratio']:.4f}"]
        cells += [number("cycle_peak_to_peak", place["cycle_peak_to_peak"])]
        cells += [f"{100.0 * place['edge_share']:.1f}"]
        return ["-" if cell.strip("+") == "nan" else cell for cell in cells]

    def _notes(self, k: int) -> list[str]:
        """Say what cannot be reached, and the nearest that can."""
        found, at = self.found, f"{100.0 * self.found.at[k]:g} %"
        status, face = PlaceStatus(int(found.status[k])), float(found.design.pinion.face_width)
        nearest = f"{100.0 * (found.z[k] / face + 0.5):.2f} % of the face, {_off(found, k)}"
        if status == PlaceStatus.OFF_CENTRE:
            lead = f"{at} centred in profile takes {_error_words(found, found.exact[k])}, where the pair jams"
            if np.isnan(found.z[k]):
                return [f"{lead}; no place near it in profile can be assembled"]
            return [f"{lead}; the nearest that can be assembled is {nearest}"]
        if status == PlaceStatus.OUT_OF_REACH:
            jams = ", where the pair jams" if found.jammed[k] else ""
            limits = " and ".join(
                f"{scaled(f'{name}_error', size):.4g} {unit_of(name)} of {name.replace('_', ' ')}"
                for name, size in zip(found.by, found.limits, strict=True)
            )
            return [f"{at} is out of reach within {limits} to either side; the nearest is {nearest}{jams}"]
        return []


def figures_of(found: Placement) -> dict[str, FloatArray]:
    """Give the numbers of all mountings by name, each (n)."""
    own = {name: getattr(found, name) for name in PLACED if name != "off_centre"}
    return own | {"off_centre": found.l - found.wanted_l}


def distances_of(found: Placement) -> dict[str, FloatArray]:
    """Give the mounting distances (n), mm, that axial errors among the two change, by name."""
    distance = dict(zip(DISTANCES, mounting_of(found.design).distance, strict=True))
    return {
        DISTANCES[name]: np.asarray(distance[name] + getattr(found.design.errors, name) + found.errors[:, j])
        for j, name in enumerate(found.by)
        if name in DISTANCES
    }


def _error_words(found: Placement, errors: FloatArray) -> str:
    return ", ".join(
        f"{SHORT[name]} {scaled(f'{name}_error', size):+.6f} {unit_of(name)}"
        for name, size in zip(found.by, errors, strict=True)
    )


def _off(found: Placement, k: int) -> str:
    off = found.l[k] - found.wanted_l
    return f"{abs(off):.4f} mm {'above' if off > 0.0 else 'below'} the centre of the profile"


def place_report(
    name: str, design: Design, at: tuple[float, ...], by: tuple[str, str], flank: str, l: float | None
) -> PlaceReport:
    """Place the path of a single design; arguments and ValueError as of `place_path`."""
    return PlaceReport(name, place_path(design, at, by, flank, l))
