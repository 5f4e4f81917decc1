"""Claims of the paper's statements: the quantities measured for each claim, and its criterion.

CLAIMS is the table of criteria. MEASURES computes the quantities of a statement and a sentence with the
numbers. The paper gives the largest coefficients and the offset error. We chose the thresholds for
"slightly", "clearly" and "little", the axial errors, and the shaft-angle error, which moves the path of Table
1's right flank about as far as the offset error does (15.3 and 12.7 mm)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import radians

import numpy as np

from ..analysis.path_measures import Sweep, concavity, measures_of, shifts, sweep, unwrapped
from ..analysis.sensitivity import path_sensitivity
from ..arrays import FloatArray
from ..contact.path import contact_ratio
from ..design.model import Design, Errors
from ..pair.misalignment import ERROR_NAMES
from ..status import Limit
from ..support.frozen_arrays import read_only

SMALL_PARABOLA_PER_MM = 0.0002
"""1/mm: largest coefficient of Figs. 7 and 8."""
CLAIM_PARABOLAS_PER_MM = (0.001, -0.001)
"""1/mm: coefficients of Figs. 12 to 15."""
OFFSET_ERROR, ANGLE_ERROR, AXIAL_ERROR = 0.5, radians(0.015), 0.5
"""mm, rad and mm."""
LITTLE, CLEAR = 0.01, 0.03
"""Changes of the contact ratio, relative to the unmodified one, that count as little and as clear."""
NOTICEABLE_RELATIVE_CHANGE = 0.02
"""Shift that counts as a move, relative to the face width."""
Measures = dict[str, FloatArray]
"""Values (n,), or (2 members, n), by the name of the measure."""
Measured = tuple[dict[str, Measures], str]
"""Measures by quantity, and a sentence with the numbers."""
Test = Callable[[FloatArray], bool]


@dataclass(frozen=True)
class FlankCase:
    """One flank of a design without modification and errors, with results that several statements use.

    A `sign` of -1 reverses the signs of all coefficients."""

    design: Design
    flank: str
    sign: int = 1

    @cached_property
    def modified(self) -> Design:
        """The design with the coefficients CLAIM_PARABOLAS_PER_MM."""
        return self.design.with_parabola(*(self.sign * value for value in CLAIM_PARABOLAS_PER_MM))

    @cached_property
    def sweeps(self) -> dict[str, Sweep]:
        """Results for the coefficients of C1 to C4."""
        # Signs of the coefficients of pinion and gear, and the largest coefficient: of Figs. 9 and 10 for C3
        # and C4.
        large = 0.002
        sweeps = {
            "C1": (1, 1, SMALL_PARABOLA_PER_MM),
            "C2": (-1, -1, SMALL_PARABOLA_PER_MM),
            "C3": (1, -1, large),
            "C4": (-1, 1, large),
        }
        return read_only(
            {
                name: sweep(self.design, self.flank, (self.sign * first, self.sign * second), size)
                for name, (first, second, size) in sweeps.items()
            }
        )

    @cached_property
    def face(self) -> FloatArray:
        """Face widths (2, 1), mm."""
        return read_only(np.array([[float(member.face_width)] for member in self.design.members]))

    def both_shifts(self, error: str, size: float) -> dict[str, Measures]:
        """Return the shifts under -size and +size of an error, unmodified and modified."""
        both = {"unmodified": self.design, "modified": self.modified}
        return {name: shifts(design, self.flank, error, size) for name, design in both.items()}


def grows(row: FloatArray) -> bool:
    """Return whether numbers (n,) increase throughout."""
    return bool((np.diff(row) > 0.0).all())


def ends_greater(row: FloatArray) -> bool:
    """Return whether the last number is greater than the first."""
    return bool(row[-1] > row[0])


def ends_clearly_less(row: FloatArray) -> bool:
    """Return whether the last number is less than the first by CLEAR."""
    return bool(row[-1] < (1.0 - CLEAR) * row[0])


def angle_falls(row: FloatArray) -> bool:
    """Return whether the magnitudes of angles decrease throughout, without a change of sign."""
    return grows(-np.abs(row)) and bool((row * row[0] > 0.0).all())


def turns_over(row: FloatArray) -> bool:
    """Return whether an angle grows to 90 deg and then falls with the opposite sign, in one sense of
    rotation."""
    turned = unwrapped(row)
    monotone = grows(turned) or grows(-turned)
    return monotone and bool(row[0] * row[-1] < 0.0 and abs(turned[-1]) > 90.0)


def shorter_first(row: FloatArray) -> bool:
    """Return whether numbers decrease to a minimum inside the range and increase from there."""
    least = int(row.argmin())
    return 0 < least < row.size - 1 and grows(-row[: least + 1]) and grows(row[least:])


def little_up_to_half(row: FloatArray) -> bool:
    """Return whether the first half stays within LITTLE of the first number."""
    return bool(np.abs(row[: row.size // 2 + 1] - row[0]).max() < LITTLE * row[0])


LONGER = {"throughout": grows, "at the end of the range": ends_greater}
CLAIMS: dict[str, list[tuple[str, str, Test | Mapping[str, Test]]]] = {
    "F6": [("concave for a > 0 and convex for a < 0", "concavity", lambda row: row[0] > 0.0 > row[1])],
    "C1": [
        ("the angle grows and falls with the other sign", "angle", turns_over),
        ("the path gets longer", "length", LONGER),
    ],
    "C2": [
        ("the path gets longer", "length", LONGER),
        ("the angle falls", "angle", angle_falls),
        ("it moves towards the heel", "location", lambda row: row[-1] - row[0] > NOTICEABLE_RELATIVE_CHANGE),
    ],
    "C3": [
        ("the path gets longer", "length", LONGER),
        ("the angle falls", "angle", angle_falls),
        (
            "it falls slightly",
            "fall",
            {
                "less than in C2": lambda row: 0.0 < row[0] - row[1] < row[2] - row[3],
                "by less than 50 %": lambda row: 0.0 < row[0] - row[1] < 0.5 * row[0],
            },
        ),
        ("it moves towards the toe", "location", lambda row: row[-1] - row[0] < -NOTICEABLE_RELATIVE_CHANGE),
    ],
    "C4": [
        ("shorter, then longer", "length", shorter_first),
        ("the angle grows and falls with the other sign", "angle", turns_over),
    ],
    "R1": [
        ("a small coefficient raises it", "ratio", lambda row: row.max() > row[0]),
        ("it falls clearly", "ratio", ends_clearly_less),
    ],
    "R2": [
        (f"little effect up to {SMALL_PARABOLA_PER_MM / 2:g}", "ratio", little_up_to_half),
        ("it rises clearly beyond", "ratio", lambda row: row[-1] - row[row.size // 2] > CLEAR * row[0]),
    ],
    "R3": [("it rises clearly", "ratio", lambda row: grows(row) and row[-1] > (1.0 + CLEAR) * row[0])],
    "R4": [("it falls clearly", "ratio", lambda row: grows(-row) and ends_clearly_less(row))],
    "D1": [
        ("C1 and C4 turn more than C2 and C3", "turns", lambda row: min(row[:2]) > max(row[2:])),
        ("C2 is too fine", "fineness", lambda row: row[0] > 3.0 * row[1]),
        ("C3 raises the contact ratio", "ratio", ends_greater),
        ("C3 keeps to roots and tips", "limits", lambda row: row.max() < Limit.PINION_TOE),
    ],
    "M1": [("negative to the toe, positive to the heel", "shift", lambda row: row[0] < 0.0 < row[1])],
    "M2": [("positive to the toe, negative to the heel", "shift", lambda row: row[1] < 0.0 < row[0])],
    "M3": [("it is longer", "length", ends_greater)],
    "M4": [("the shift is smaller", "shift", lambda row: row[1] < row[0])],
    "M5": [("the shift is smaller", "shift", lambda row: row[1] < row[0])],
    "M6": [
        ("the path hardly moves", "shift", lambda row: row.max() < NOTICEABLE_RELATIVE_CHANGE),
        ("the contact ratio hardly changes", "ratio", lambda row: row.max() < LITTLE),
    ],
}
"""By statement: text of a claim, quantity measured for it, and criterion for its values (n,), or several
criteria by name."""


def _course(row: FloatArray, size: FloatArray, unit: str) -> str:
    """Return the first value of a sweep, its extrema inside the range, and the last value, as text."""
    if not np.isfinite(row).all():
        return f"{np.isfinite(row).sum()} of {row.size} paths on the flanks"
    text = f"{row[0]:z.4g} at 0"
    inside = [int(k) for k in (row.argmin(), row.argmax()) if 0 < k < row.size - 1]
    text += "".join(f", {row[k]:z.4g} at {size[k]:.3g}" for k in inside)
    return f"{text}, {row[-1]:z.4g} {unit}".rstrip() + f" at {size[-1]:.3g} 1/mm"


def _concavity(case: FlankCase) -> Measured:
    measures = concavity(case.design, case.flank, case.sign * 0.01)  # 1/mm, as in Fig. 6
    metal = measures["metal near root and tip"][0]
    least = f"at least {metal[0]:.3g} mm with a = {case.sign * 0.01}"
    most = f"at most {metal[1]:.3g} mm with a = {case.sign * -0.01} 1/mm"
    words = f"additional metal near root and tip of the pinion: {least}, {most}"
    return {"concavity": measures}, words


def _sweep(name: str, moves: bool, case: FlankCase) -> Measured:
    """Return lengths, angles and locations of a sweep; the locations are in the sentence if the path
    `moves`."""
    # Name, quantity, measure and unit of the values in the sentence.
    shown = [("length", "length", "side view", "mm"), ("angle of the chord", "angle", "chord", "deg")]
    if moves:
        shown.append(("z of the middle", "location", "middle", "mm"))
    parabola_sweep, small = case.sweeps[name], case.sweeps["C2"].paths.angle
    falls = {  # first and last magnitude of the angle, here and in C2
        measure: np.stack((*np.abs(rows[:, [0, -1]]).T, *np.abs(small[measure][:, [0, -1]]).T), axis=-1)
        for measure, rows in parabola_sweep.paths.angle.items()
    }
    places = {measure: z / case.face for measure, z in parabola_sweep.paths.location.items()}
    words = [
        f"{text} {_course(getattr(parabola_sweep.paths, quantity)[measure][0], parabola_sweep.size, unit)}"
        for text, quantity, measure, unit in shown
    ]
    paths = parabola_sweep.paths
    quantities = {"length": paths.length, "angle": paths.angle, "location": places, "fall": falls}
    return quantities, f"pinion in the side view: {'; '.join(words)}"


def _ratios(name: str, case: FlankCase) -> Measured:
    """Return the contact ratios of a sweep, with and without the limits at toe and heel; NaN without a
    path."""
    parabola_sweep, design = case.sweeps[name], case.design
    pinion, gear = (replace(m, face_width=6.0 * m.face_width) for m in design.members)
    wide = replace(design, pinion=pinion, gear=gear).with_parabola(
        *(sign * parabola_sweep.size for sign in parabola_sweep.signs)
    )
    both = {
        "Eq. 16": parabola_sweep.paths.contact_ratio,
        "Eq. 16 without toe and heel": contact_ratio(wide, case.flank),
    }
    measures = {measure: np.where(ratio > 0.0, ratio, np.nan) for measure, ratio in both.items()}
    return {"ratio": measures}, "; ".join(
        f"{measure}: {_course(row, parabola_sweep.size, '')}" for measure, row in measures.items()
    )


def _ratios_to_half(case: FlankCase) -> Measured:
    """Return the contact ratios for R2; the sentence includes the value at half the range, which its first
    claim uses."""
    quantities, words = _ratios("C2", case)
    ratio = quantities["ratio"]["Eq. 16"]
    return quantities, f"{words}; Eq. 16 at {SMALL_PARABOLA_PER_MM / 2:g} 1/mm: {ratio[ratio.size // 2]:.4g}"


def _turn(parabola_sweep: Sweep, index: int) -> FloatArray:
    """Return the rotation (2,) of the chord of both members, deg, from the first to another coefficient."""
    angle = unwrapped(parabola_sweep.paths.angle["chord"])
    return np.asarray(np.abs(angle[:, index] - angle[:, 0]))


def _turns(case: FlankCase) -> Measured:
    names, sweeps = ("C1", "C4", "C2", "C3"), case.sweeps
    total = {name: _turn(sweeps[name], -1) for name in names}
    rate = {name: total[name] / sweeps[name].size[-1] for name in names}
    near_0 = {name: _turn(sweeps[name], 1) / sweeps[name].size[1] for name in names}
    best = sweeps["C3"].paths
    limits = np.where(best.limit < 0, np.nan, best.limit).ravel()

    def rows(values: Mapping[str, FloatArray], first: int) -> FloatArray:
        return np.stack([values[name] for name in names[first:]], axis=-1)

    quantities = {
        "turns": {"turn over the range": rows(total, 0), "turn by coefficient": rows(rate, 0)},
        "fineness": {"turn by coefficient": rows(rate, 2), "turn by coefficient near 0": rows(near_0, 2)},
        "ratio": {"Eq. 16": best.contact_ratio},
        "limits": {"limits": limits},
    }
    words = ", ".join(f"{total[name][0]:.4g}{' deg' if name == 'C1' else ''} in {name}" for name in names)
    return quantities, f"the pinion's path turns by {words}"


def _moves(error: str, size: float, case: FlankCase) -> Measured:
    design_shifts = case.both_shifts(error, size)
    measures = {
        f"{name}, {design}": rows
        for design, measures in design_shifts.items()
        for name, rows in measures.items()
    }
    first, second = design_shifts["unmodified"]["along the face, equal l"][0]
    words = f"the pinion's unmodified path shifts by {first:z.4g} and {second:z.4g} mm along the face"
    return {"shift": measures}, words


def _lengths(case: FlankCase) -> Measured:
    both = case.design.with_parabola(*(np.array((0.0, case.sign * a)) for a in CLAIM_PARABOLAS_PER_MM))
    lengths = measures_of(both, case.flank).length
    before, after = lengths["side view"][0]
    words = f"the pinion's path in the side view is {before:.4g} mm long unmodified, {after:.4g} mm modified"
    return {"length": lengths}, words


def _smaller(error: str, size: float, case: FlankCase) -> Measured:
    """Return the mean shifts without and with modification, and the derivatives with respect to the error."""
    both = case.both_shifts(error, size)
    measures = {
        name: np.stack([np.abs(by_measure[name]).mean(axis=-1) for by_measure in both.values()], axis=-1)
        for name in both["unmodified"]
    }
    rates = [path_sensitivity(design, case.flank) for design in (case.design, case.modified)]
    for field, name in (("face_shift_by", "along the face"), ("square_shift_by", "square, on the tooth")):
        rows = [np.abs(getattr(rate, field)[1, :, ERROR_NAMES.index(error)]) for rate in rates]
        measures[f"{name}, derivative"] = np.stack(rows, axis=-1)
    along, square = measures["along the face, equal l"][0], measures["square, side view"][0]
    words = (
        f"the shift on the pinion changes from {along[0]:.4g} to {along[1]:.4g} mm along the face, and from"
        f" {square[0]:.4g} to {square[1]:.4g} mm perpendicular to the path in the side view"
    )
    return {"shift": measures}, words


def _axial(case: FlankCase) -> Measured:
    """Return shifts in face widths and relative changes of the contact ratio under axial errors."""
    measures: Measures = {}
    ratios: Measures = {}
    errors = np.array((-AXIAL_ERROR, AXIAL_ERROR))
    for error in ("pinion_axial", "gear_axial"):
        words = error.replace("_", " ")
        for name, by_measure in case.both_shifts(error, AXIAL_ERROR).items():
            for measure in ("along the face, equal l", "at mid-roll"):
                measures[f"{measure}, {name}, {words}"] = np.abs(by_measure[measure]) / case.face
        for name, design in (("unmodified", case.design), ("modified", case.modified)):
            ratio = contact_ratio(design.with_errors(Errors(**{error: errors})), case.flank)
            ratios[f"{name}, {words}"] = np.abs(ratio / contact_ratio(design, case.flank) - 1.0)
    most, worst = (max(float(rows.max()) for rows in quantity.values()) for quantity in (measures, ratios))
    words = f"the path moves by {100 * most:.2f} % of the face width at most, the contact ratio by"
    return {"shift": measures, "ratio": ratios}, f"{words} {100 * worst:.2f} %"


MEASURES: dict[str, Callable[[FlankCase], Measured]] = {
    "F6": _concavity,
    "C1": partial(_sweep, "C1", False),
    "C2": partial(_sweep, "C2", True),
    "C3": partial(_sweep, "C3", True),
    "C4": partial(_sweep, "C4", False),
    "R1": partial(_ratios, "C1"),
    "R2": _ratios_to_half,
    "R3": partial(_ratios, "C3"),
    "R4": partial(_ratios, "C4"),
    "D1": _turns,
    "M1": partial(_moves, "offset", OFFSET_ERROR),
    "M2": partial(_moves, "shaft_angle", ANGLE_ERROR),
    "M3": _lengths,
    "M4": partial(_smaller, "offset", OFFSET_ERROR),
    "M5": partial(_smaller, "shaft_angle", ANGLE_ERROR),
    "M6": _axial,
}
