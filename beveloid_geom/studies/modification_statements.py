"""The paper's statements on parabola coefficients: F6, C1 to C4, R1 to R4, D1 (Figs. 6 to 11).

`SLIGHT` and `FINER` are ours, as the sizes in `statement_verdicts`.
"""

from __future__ import annotations

import numpy as np

from ..analysis.path_measures import Paths, Sweep, concavity, unwrapped
from ..arrays import FloatArray
from ..status import Limit
from .statement_verdicts import (
    CLEAR,
    LARGE,
    LENGTH_WORDS,
    LITTLE,
    NOTICEABLE,
    SMALL,
    WIDE,
    Case,
    Statement,
    Test,
    claim_of,
    ends_greater,
    grows,
)

DRAWN = 0.01
"""1/mm: coefficients of Fig. 6."""
SLIGHT, FINER = 0.5, 3.0
"""Share of an angle by which it falls at most; ratio of the turns by coefficient from which one counts as
finer."""


def _angle_falls(row: FloatArray) -> bool:
    return grows(-np.abs(row)) and bool((row * row[0] > 0.0).all())


def _turns_over(row: FloatArray) -> bool:
    """The angle grows up to 90 deg and falls from there with the other sign, turning one way."""
    turned = unwrapped(row)
    one_way = grows(turned) or grows(-turned)
    return one_way and bool(row[0] * row[-1] < 0.0 and abs(turned[-1]) > 90.0)


def _shorter_first(row: FloatArray) -> bool:
    least = int(row.argmin())
    return 0 < least < row.size - 1 and grows(-row[: least + 1]) and grows(row[least:])


LONGER = (("throughout", grows), ("at the end of the range", ends_greater))
ANGLE_WORDS = "angle to the axial direction in the side view, of the chord and of the middle, deg"
PLACE_WORDS = (
    "location as z of the middle of the roll and between the ends, in face widths from mid-face towards the"
    f" heel, moved where by more than {100 * NOTICEABLE:g} %"
)


def _course(row: FloatArray, size: FloatArray, unit: str) -> str:
    """First, least or greatest between, and last value of a sweep."""
    if not np.isfinite(row).all():
        return f"{np.isfinite(row).sum()} of {row.size} paths on the flanks"
    text = f"{row[0]:z.4g}"
    inside = [int(k) for k in (row.argmin(), row.argmax()) if 0 < k < row.size - 1]
    text += "".join(f", {row[k]:z.4g} at {size[k]:.3g} 1/mm" for k in inside)
    return f"{text}, {row[-1]:z.4g} {unit}".rstrip() + f" at {size[-1]:.3g} 1/mm"


def _case_detail(found: Sweep) -> str:
    paths = found.paths
    length = _course(paths.length["side view"][0], found.size, "mm")
    angle = _course(paths.angle["chord"][0], found.size, "deg")
    return f"pinion in the side view: length {length}, angle of the chord {angle}"


def _locations(case: Case, paths: Paths) -> dict[str, FloatArray]:
    return {name: z / case.face for name, z in paths.location.items()}


def _location_detail(found: Sweep) -> str:
    return f", z of the middle {_course(found.paths.location['middle'][0], found.size, 'mm')}"


def f6(case: Case) -> Statement:
    """Statement F6."""
    found = concavity(case.design, case.flank, case.sign * DRAWN)
    metal = found["metal near root and tip"][0]
    return Statement(
        "F6",
        case.flank,
        "A positive coefficient makes the flank concave against the involute one, a negative one convex.",
        f"At mid-face, coefficients of +/-{DRAWN:g} 1/mm: metal left near root and tip at equal radius, mm,"
        " and by how much the profile's curvature falls, 1/mm.",
        (claim_of("concave for a > 0 and convex for a < 0", found, ("", lambda row: row[0] > 0.0 > row[1])),),
        f"the pinion has {metal[0]:.3g} and {metal[1]:.3g} mm more metal near root and tip",
    )


def c1(case: Case) -> Statement:
    """Statement C1."""
    found = case.sweeps["C1"]
    return Statement(
        "C1",
        case.flank,
        f"Both coefficients from 0 to {SMALL:g}: the angle of the path grows, then falls with the opposite"
        " direction; the path gets longer.",
        f"{ANGLE_WORDS}; {LENGTH_WORDS}.",
        (
            claim_of("the angle grows and falls with the other sign", found.paths.angle, ("", _turns_over)),
            claim_of("the path gets longer", found.paths.length, *LONGER),
        ),
        _case_detail(found),
    )


def c2(case: Case) -> Statement:
    """Statement C2."""
    found = case.sweeps["C2"]
    return Statement(
        "C2",
        case.flank,
        f"Both coefficients from 0 to -{SMALL:g}: the path gets longer, its angle falls, and it moves from"
        " the middle towards the heel.",
        f"{LENGTH_WORDS}; {ANGLE_WORDS}; {PLACE_WORDS}.",
        (
            claim_of("the path gets longer", found.paths.length, *LONGER),
            claim_of("the angle falls", found.paths.angle, ("", _angle_falls)),
            claim_of(
                "it moves towards the heel",
                _locations(case, found.paths),
                ("", lambda row: row[-1] - row[0] > NOTICEABLE),
            ),
        ),
        _case_detail(found) + _location_detail(found),
    )


def c3(case: Case) -> Statement:
    """Statement C3."""
    found, small = case.sweeps["C3"], case.sweeps["C2"].paths.angle
    falls = {
        name: np.stack((*np.abs(rows[:, [0, -1]]).T, *np.abs(small[name][:, [0, -1]]).T), axis=-1)
        for name, rows in found.paths.angle.items()
    }
    return Statement(
        "C3",
        case.flank,
        f"a1 > 0 > a2 up to {LARGE:g}: the path gets longer, its angle falls slightly, and it moves from the"
        " middle towards the toe.",
        f"{LENGTH_WORDS}; {ANGLE_WORDS}, slightly if by less than in C2, and by less than"
        f" {100 * SLIGHT:g} %; {PLACE_WORDS}.",
        (
            claim_of("the path gets longer", found.paths.length, *LONGER),
            claim_of("the angle falls", found.paths.angle, ("", _angle_falls)),
            claim_of(
                "it falls slightly",
                falls,
                ("less than in C2", lambda row: 0.0 < row[0] - row[1] < row[2] - row[3]),
                (f"by less than {100 * SLIGHT:g} %", lambda row: 0.0 < row[0] - row[1] < SLIGHT * row[0]),
            ),
            claim_of(
                "it moves towards the toe",
                _locations(case, found.paths),
                ("", lambda row: row[-1] - row[0] < -NOTICEABLE),
            ),
        ),
        _case_detail(found) + _location_detail(found),
    )


def c4(case: Case) -> Statement:
    """Statement C4."""
    found = case.sweeps["C4"]
    return Statement(
        "C4",
        case.flank,
        f"a1 < 0 < a2 up to {LARGE:g}: the path gets shorter, then longer; its angle grows, then falls with"
        " the opposite direction.",
        f"{LENGTH_WORDS}; {ANGLE_WORDS}.",
        (
            claim_of("shorter, then longer", found.paths.length, ("", _shorter_first)),
            claim_of("the angle grows and falls with the other sign", found.paths.angle, ("", _turns_over)),
        ),
        _case_detail(found),
    )


RATIO_WORDS = (
    f"contact ratio of Eq. 16, and the same of faces {WIDE:g} times as wide;"
    f" clearly means by {100 * CLEAR:g} %"
)


def _ratio(
    case: Case, id_: str, text: str, name: str, *claims: tuple[str, Test], words: str = "", more: str = ""
) -> Statement:
    ways, size = case.ratios(name), case.sweeps[name].size
    detail = ", ".join(f"{way}: {_course(row, size, '')}" for way, row in ways.items()) + more
    return Statement(
        id_,
        case.flank,
        text,
        f"{RATIO_WORDS}{words}.",
        tuple(claim_of(claim, ways, ("", test)) for claim, test in claims),
        detail,
    )


def r1(case: Case) -> Statement:
    """Statement R1."""
    return _ratio(
        case,
        "R1",
        "Both coefficients positive: a small one can raise the contact ratio, then it falls clearly.",
        "C1",
        ("a small coefficient raises it", lambda row: row.max() > row[0]),
        ("it falls clearly", lambda row: row[-1] < (1.0 - CLEAR) * row[0]),
        words=", by any amount for a small coefficient",
    )


def r2(case: Case) -> Statement:
    """Statement R2."""

    def little(row: FloatArray) -> bool:
        return bool(np.abs(row[: row.size // 2 + 1] - row[0]).max() < LITTLE * row[0])

    def rises(row: FloatArray) -> bool:
        return bool(row[-1] - row[row.size // 2] > CLEAR * row[0])

    ratio = case.ratios("C2")["Eq. 16"]
    half = ratio[ratio.size // 2]
    return _ratio(
        case,
        "R2",
        f"Both negative: little effect on the contact ratio up to {SMALL / 2:g}, then it rises clearly.",
        "C2",
        (f"little effect up to {SMALL / 2:g}", little),
        ("it rises clearly beyond", rises),
        words=f", little means {100 * LITTLE:g} %",
        more=f", by Eq. 16 {half:.4g} at {SMALL / 2:g} 1/mm",
    )


def _rises_clearly(row: FloatArray) -> bool:
    return bool(grows(row) and row[-1] > (1.0 + CLEAR) * row[0])


def _falls_clearly(row: FloatArray) -> bool:
    return bool(grows(-row) and row[-1] < (1.0 - CLEAR) * row[0])


def r3(case: Case) -> Statement:
    """Statement R3."""
    claim = ("it rises clearly", _rises_clearly)
    return _ratio(case, "R3", "a1 > 0 > a2: the contact ratio rises clearly.", "C3", claim)


def r4(case: Case) -> Statement:
    """Statement R4."""
    claim = ("it falls clearly", _falls_clearly)
    return _ratio(case, "R4", "a1 < 0 < a2: the contact ratio falls clearly.", "C4", claim)


def d1(case: Case) -> Statement:
    """Statement D1."""
    total = {name: np.abs(_turn(found, -1)) for name, found in case.sweeps.items()}
    largest = {name: found.size[-1] for name, found in case.sweeps.items()}
    start = {name: np.abs(_turn(found, 1)) / found.size[1] for name, found in case.sweeps.items()}
    names = ("C1", "C4", "C2", "C3")
    turns = {
        "turn over the range": np.stack([total[name] for name in names], axis=-1),
        "turn by coefficient": np.stack([total[name] / largest[name] for name in names], axis=-1),
    }
    fine = {
        "turn by coefficient": np.stack([total[name] / largest[name] for name in ("C2", "C3")], axis=-1),
        "turn by coefficient near 0": np.stack([start[name] for name in ("C2", "C3")], axis=-1),
    }
    best = case.sweeps["C3"].paths
    limits = np.where(best.limit < 0, np.nan, best.limit).ravel()
    shares = turns["turn over the range"][0]
    return Statement(
        "D1",
        case.flank,
        "The angle is more sensitive in C1 and C4, so that C2 and C3 are easier to control; C2 needs too"
        " fine a coefficient; C3 is recommended.",
        "Turn of the chord in the side view over the ranges of C1 to C4, deg, and by coefficient, deg mm; C2"
        f" is too fine if it turns {FINER:g} times as much by coefficient as C3; C3 is recommended for a"
        " higher contact ratio of Eq. 16, on a path between roots and tips.",
        (
            claim_of(
                "C1 and C4 turn more than C2 and C3", turns, ("", lambda row: min(row[:2]) > max(row[2:]))
            ),
            claim_of("C2 is too fine", fine, ("", lambda row: row[0] > FINER * row[1])),
            claim_of("C3 raises the contact ratio", {"Eq. 16": best.contact_ratio}, ("", ends_greater)),
            claim_of(
                "C3 keeps to roots and tips",
                {"limits": limits},
                ("", lambda row: row.max() < Limit.PINION_TOE),
            ),
        ),
        "the pinion's path turns by {:.4g} deg in C1, {:.4g} in C4, {:.4g} in C2, {:.4g} in C3".format(
            *shares
        ),
    )


def _turn(found: Sweep, index: int) -> FloatArray:
    angle = unwrapped(found.paths.angle["chord"])
    return np.asarray(angle[:, index] - angle[:, 0])
