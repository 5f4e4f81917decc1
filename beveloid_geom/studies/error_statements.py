"""The paper's statements on assembly errors: M1 to M6 (Figs. 12 to 15).

The paper gives the size of the offset error alone; the others are ours. The shaft-angle error moves
the path of Table 1's right flank as far as the offset error does.
"""

from __future__ import annotations

from math import radians

import numpy as np

from ..analysis.path_measures import paths_of
from ..analysis.sensitivity import ERRORS, path_sensitivity
from ..arrays import FloatArray
from ..contact.path import contact_ratio
from ..design.model import Errors
from .statement_verdicts import (
    LENGTH_WORDS,
    LITTLE,
    MODIFIED,
    NOTICEABLE,
    Case,
    Statement,
    Test,
    claim_of,
    ends_greater,
)

OFFSET_ERROR, AXIAL_ERROR, ANGLE_ERROR = 0.5, 0.5, radians(0.015)
"""mm and rad."""


def _moves(case: Case, id_: str, text: str, error: str, size: float, claim: str, test: Test) -> Statement:
    found = case.both_shifts(error, size)
    ways = {f"{name}, {design}": rows for design, ways in found.items() for name, rows in ways.items()}
    shown = found["unmodified"]["along the face, equal l"][0]
    return Statement(
        id_,
        case.flank,
        text,
        f"Shift of the path under -/+{_size_words(error, size)}, mm, positive towards the heel, along the"
        " face, square to the path and at mid-roll, unmodified and modified.",
        (claim_of(claim, ways, ("", test)),),
        f"the pinion's unmodified path shifts by {shown[0]:z.4g} and {shown[1]:z.4g} mm along the face",
    )


def _size_words(error: str, size: float) -> str:
    return f"{np.degrees(size):.3g} deg" if error == "shaft_angle" else f"{size:g} mm"


def m1(case: Case) -> Statement:
    """Statement M1."""
    size = f"{OFFSET_ERROR:g} mm"
    text = f"An offset error of -{size} moves the path towards the toe, +{size} towards the heel."
    claim = "negative to the toe, positive to the heel"
    return _moves(case, "M1", text, "offset", OFFSET_ERROR, claim, lambda row: row[0] < 0.0 < row[1])


def m2(case: Case) -> Statement:
    """Statement M2."""
    text = "A positive shaft-angle error moves the path towards the toe, a negative one to the heel."
    claim = "positive to the toe, negative to the heel"
    return _moves(case, "M2", text, "shaft_angle", ANGLE_ERROR, claim, lambda row: row[1] < 0.0 < row[0])


def m3(case: Case) -> Statement:
    """Statement M3."""
    found = paths_of(
        case.design.with_parabola(*(np.array((0.0, case.sign * a)) for a in MODIFIED)), case.flank
    ).length
    before, after = found["side view"][0]
    return Statement(
        "M3",
        case.flank,
        f"With a1 = {MODIFIED[0]:g}, a2 = {MODIFIED[1]:g} the path is longer than unmodified.",
        f"{LENGTH_WORDS}.",
        (claim_of("it is longer", found, ("", ends_greater)),),
        f"the pinion's path in the side view is {before:.4g} mm long unmodified, {after:.4g} mm modified",
    )


def _smaller(case: Case, id_: str, error: str, size: float) -> Statement:
    both = case.both_shifts(error, size)
    ways = {
        name: np.stack([np.abs(both[design][name]).mean(axis=-1) for design in both], axis=-1)
        for name in both["unmodified"]
    }
    rates = [path_sensitivity(design, case.flank) for design in (case.design, case.modified)]
    k, words = (
        ERRORS.index(error),
        {"face_shift_by": "along the face", "square_shift_by": "square, on the tooth"},
    )
    for field, name in words.items():
        rows = [np.abs(getattr(rate, field)[1, :, k]) for rate in rates]
        ways[f"{name}, derivative"] = np.stack(rows, axis=-1)
    along, square = ways["along the face, equal l"][0], ways["square, side view"][0]
    which = "an offset" if error == "offset" else "a shaft-angle"
    return Statement(
        id_,
        case.flank,
        f"Modified, the path shifts less under {which} error than unmodified.",
        f"Mean of the shifts under -/+{_size_words(error, size)}, mm, along the face, square to the path and"
        " at mid-roll; and the exact derivatives at no error, by mm or rad.",
        (claim_of("the shift is smaller", ways, ("", lambda row: row[1] < row[0])),),
        f"the pinion's goes from {along[0]:.4g} to {along[1]:.4g} mm along the face, and from {square[0]:.4g}"
        f" to {square[1]:.4g} mm square to the path in the side view",
    )


def m4(case: Case) -> Statement:
    """Statement M4."""
    return _smaller(case, "M4", "offset", OFFSET_ERROR)


def m5(case: Case) -> Statement:
    """Statement M5."""
    return _smaller(case, "M5", "shaft_angle", ANGLE_ERROR)


def m6(case: Case) -> Statement:
    """Statement M6."""
    ways: dict[str, FloatArray] = {}
    ratios: dict[str, FloatArray] = {}
    errors = np.array((-AXIAL_ERROR, AXIAL_ERROR))
    for error in ("pinion_axial", "gear_axial"):
        words = error.replace("_", " ")
        for name, found in case.both_shifts(error, AXIAL_ERROR).items():
            for way in ("along the face, equal l", "at mid-roll"):
                ways[f"{way}, {name}, {words}"] = np.abs(found[way]) / case.face
        for name, design in (("unmodified", case.design), ("modified", case.modified)):
            ratio = contact_ratio(design.with_errors(Errors(**{error: errors})), case.flank)
            ratios[f"{name}, {words}"] = np.abs(ratio / contact_ratio(design, case.flank) - 1.0)
    most = max((float(rows.max()) for rows in ways.values()), default=np.nan)
    worst = max((float(row.max()) for row in ratios.values()), default=np.nan)
    return Statement(
        "M6",
        case.flank,
        "Axial errors of pinion or gear hardly matter.",
        f"Shift along the face and at mid-roll under -/+{AXIAL_ERROR:g} mm, in face widths, less than"
        f" {100 * NOTICEABLE:g} %; change of the contact ratio of Eq. 16, less than {100 * LITTLE:g} %.",
        (
            claim_of("the path hardly moves", ways, ("", lambda row: row.max() < NOTICEABLE)),
            claim_of("the contact ratio hardly changes", ratios, ("", lambda row: row.max() < LITTLE)),
        ),
        f"the path moves by {100 * most:.2f} % of the face width at most, the contact ratio by"
        f" {100 * worst:.2f} %",
    )
