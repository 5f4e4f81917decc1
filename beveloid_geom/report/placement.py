"""Report of `place`: errors that move the path to given places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.path_placement import Placement, place_path
from ..arrays import FloatArray
from ..design.model import Design
from ..pair.mounting import mounting_of
from ..status import NotComputed, PlaceStatus
from .columns import aligned, number, scaled
from .result import Failure, ResultReport, Rows, picked, plain, stacked_rows
from .text import ERROR_SYMBOLS, SYMBOLS, line, mounted_lines, symbol_words, unit_of


@dataclass(frozen=True, eq=False)
class PlaceReport(ResultReport[Placement]):
    """Mountings of a single design whose paths have their middle at given places of the face."""

    @property
    def reason(self) -> str | None:
        """Reason why no position has values, None if one has; `NotComputed` if a search did not converge."""
        status = self.result.status
        if np.isfinite(self.result.z).any():
            return None
        if (status == PlaceStatus.NO_PATH).all():
            return f"no mounting tried has a path on the {self.flank} flanks"
        if (status == PlaceStatus.NOT_CONVERGED).any():
            which = "none" if (status == PlaceStatus.NOT_CONVERGED).all() else "not all"
            return NotComputed(f"{which} of the positions could be computed: the search did not converge")
        return "the pair cannot be assembled at the required positions or at nearby positions in profile"

    @property
    def failure(self) -> Failure | None:
        """Failure if no position has values."""
        jams = (self.result.status == PlaceStatus.JAMMED).any()
        if self.reason and jams and not isinstance(self.reason, NotComputed):
            return Failure(f"Jammed: {self.reason}")
        return super().failure

    @property
    def places(self) -> list[dict[str, Any]]:
        """Results of each place by name, mm and rad."""
        result, places = self.result, []
        figures = vars(result) | {"off_centre": result.l - result.wanted_l}
        names = [
            "z",
            "l",
            "off_centre",
            "contact_ratio",
            "cycle_peak_to_peak",
            "edge_share",
            "normal_backlash",
        ]
        for k, code in enumerate(result.status.tolist()):
            place: dict[str, Any] = {"at": result.at[k], "status": plain(PlaceStatus(code))}
            place |= {f"{name}_error": result.errors[k, j] for j, name in enumerate(result.by)}
            place |= {name: values[k] for name, values in distances_of(result).items()}
            place |= {name: figures[name][k] for name in names} | {"jammed": bool(result.jammed[k])}
            place |= {f"exact_{name}_error": result.exact[k, j] for j, name in enumerate(result.by)}
            places.append(place)
        return places

    def values(self) -> dict[str, Any]:
        """Return the places; mm and rad."""
        result = self.result
        symbols = [SYMBOLS.get(name) for name in result.by]
        limits = picked(result, "limits", "wanted_l")
        return {"by": result.by, "trade": symbols, **limits, "places": self.places}

    def rows(self) -> Rows:
        """Return the places."""
        return stacked_rows(self.places)

    def summary(self) -> str:
        """Return the places, the reasons for places that cannot be reached, and the definitions of the
        columns."""
        # Characters of the columns of the text.
        place_widths = (7, 12, 12, 10, 9, 8, 12, 10)
        result = self.result
        by = " and ".join(name.replace("_", " ") for name in result.by)
        text = f"Placing the path of {self.name} by {by}, {result.flank} flanks\n\n"
        headings = ["face, %", *(f"{ERROR_SYMBOLS[name]}, {unit_of(name)}" for name in result.by)]
        headings += ["z, mm", "dl, mm", "ratio", "TE, arcsec", "edges, %"]
        text += aligned(headings, place_widths) + "  status\n"
        for place in self.places:
            text += aligned(self._cells(place), place_widths) + f"  {place['status'].replace('_', ' ')}\n"
        text += "\n" + mounted_lines(result.design)
        text += line("errors added", ", ".join(symbol_words(name) for name in result.by))
        text += line(
            "face, z, dl",
            "middle of the path on the pinion: share of the face from the end at -z, distance from mid-face,"
            f" and l1 minus the required l1 = {result.wanted_l:z.4f} mm, which is centred in profile by"
            " default; l1 is the position along the tool flank from the apex of its parabola, positive"
            " towards the tip",
        )
        text += line(
            "ratio, TE, edges",
            "contact ratio (Eq. 16), transmission error of all teeth, share of the mesh cycle with edge"
            " contact",
        )
        letters = {"pinion_mounting": "dw1", "gear_mounting": "dw2"}
        for k, share in enumerate(result.at):
            distances = [
                (letters[name], z[k]) for name, z in distances_of(result).items() if np.isfinite(z[k])
            ]
            if words := [f"{letter} = {z:z.6f} mm" for letter, z in distances]:
                text += line(f"at {100.0 * share:g} %", ", ".join(words))
        return text + "".join(line("note", note) for k in range(result.at.size) for note in self._notes(k))

    def _cells(self, place: dict[str, Any]) -> list[str]:
        """Return the cells of one place."""
        names = [f"{name}_error" for name in self.result.by]
        cells = [f"{100.0 * place['at']:g}"]
        cells += [f"{scaled(name, place[name]):+.6f}" for name in names]
        cells += [f"{place['z']:z.4f}", f"{place['off_centre']:z.4f}", f"{place['contact_ratio']:.4f}"]
        cells += [number("cycle_peak_to_peak", place["cycle_peak_to_peak"])]
        cells += [f"{100.0 * place['edge_share']:.1f}"]
        return ["-" if cell.strip("+") == "nan" else cell for cell in cells]

    def _notes(self, k: int) -> list[str]:
        """Return the reason if a position cannot be reached, and the nearest position that can be reached."""
        result, at = self.result, f"{100.0 * self.result.at[k]:g} %"
        status, face = PlaceStatus(int(result.status[k])), float(result.design.pinion.face_width)
        nearest = f"{100.0 * (result.z[k] / face + 0.5):.1f} % of the face, {_off(result, k)}"
        if status in (PlaceStatus.OFF_CENTRE, PlaceStatus.JAMMED):
            lead = (
                f"{at} of the face at the required l1 needs {_error_words(result, result.exact[k])}, but the"
                " pair jams there"
            )
            if status == PlaceStatus.JAMMED:
                return [f"{lead}; it also jams at all nearby positions in profile"]
            return [f"{lead}; the nearest position at which it can be assembled is {nearest}"]
        if status == PlaceStatus.NOT_CONVERGED:
            not_converged = "Newton's method did not converge"
            limits = " and ".join(
                f"{scaled(f'{name}_error', size):.4g} {unit_of(name)} of {name.replace('_', ' ')}"
                for name, size in zip(result.by, result.limits, strict=True)
            )
            return [f"{at}: no mounting was found within {limits} to either side ({not_converged})"]
        return []


def distances_of(result: Placement) -> dict[str, FloatArray]:
    """Return the mounting distances (n,), mm, that are changed by axial errors, by name."""
    # Mounting distances by the axial error that changes them.
    distances = {"pinion_axial": "pinion_mounting", "gear_axial": "gear_mounting"}
    distance = dict(zip(distances, mounting_of(result.design).distance, strict=True))
    return {
        distances[name]: np.asarray(
            distance[name] + getattr(result.design.errors, name) + result.errors[:, j]
        )
        for j, name in enumerate(result.by)
        if name in distances
    }


def _error_words(result: Placement, errors: FloatArray) -> str:
    """Return two errors with symbols and units."""
    return ", ".join(
        f"{ERROR_SYMBOLS[name]} {scaled(f'{name}_error', size):+.6f} {unit_of(name)}"
        for name, size in zip(result.by, errors, strict=True)
    )


def _off(result: Placement, k: int) -> str:
    """Return the difference of l1 from the required l1."""
    off = result.l[k] - result.wanted_l
    return f"with l1 {abs(off):.4f} mm {'above' if off > 0.0 else 'below'} the required l1"


def place_report(
    name: str, design: Design, at: tuple[float, ...], by: tuple[str, str], flank: str, l: float | None
) -> PlaceReport:
    """Return the placement of the path of a single design; arguments and ValueError as in `place_path`."""
    return PlaceReport(name, design, place_path(design, at, by, flank, l))
