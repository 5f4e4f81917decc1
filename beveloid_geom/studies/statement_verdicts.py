"""What a verdict on a statement of the paper is made of: claims, the ways to measure them, sweeps.

A statement makes one or more claims. The paper's words can be measured in several ways
(`analysis.path_measures`), and each way gives its own answer, on pinion and gear. A statement holds if all
its claims hold in all ways; it does not hold if a claim holds in none; otherwise it depends on the
measure. Ways that give no number, as where a path has left the flanks, are left out; a claim with no
way left is not known.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import Any

import numpy as np

from ..analysis.path_measures import Sweep, shifts, sweep
from ..arrays import FloatArray
from ..contact.path import contact_ratio
from ..design.model import Design
from ..support.read_only import read_only

SMALL, LARGE = 0.0002, 0.002
"""1/mm: the greatest coefficients of Figs. 7 and 8, and of 9 and 10."""
MODIFIED = (0.001, -0.001)
"""1/mm: coefficients of Figs. 12 to 15."""
LITTLE, CLEAR, NOTICEABLE = 0.01, 0.03, 0.02
"""Shares of the unmodified contact ratio; share of the face width. The paper gives no sizes."""
WIDE = 6.0
"""Face widths for a contact ratio that toe and heel do not limit."""
SIGNS = {"C1": (1, 1), "C2": (-1, -1), "C3": (1, -1), "C4": (-1, 1)}
LENGTH_WORDS = "path length of pinion and gear, in the side view and on the tooth, mm"
MEMBERS = ("pinion", "gear")
Test = Callable[[FloatArray], bool]


class Verdict(Enum):
    """What the calculation says of a statement."""

    HOLDS = "holds"
    DOES_NOT_HOLD = "does not hold"
    DEPENDS = "depends on the measure"
    NOT_KNOWN = "not known"


@dataclass(frozen=True, eq=False)
class Claim:
    """One claim of a statement: by the names of the ways to measure it, the `numbers` (n,) and whether it
    `holds`, None where a number is not known."""

    text: str
    numbers: dict[str, FloatArray]
    holds: dict[str, bool | None]

    @property
    def verdict(self) -> Verdict:
        """Of the claim, from the ways that are known."""
        known = {value for value in self.holds.values() if value is not None}
        if not known:
            return Verdict.NOT_KNOWN
        return Verdict.DEPENDS if len(known) > 1 else Verdict.HOLDS if known.pop() else Verdict.DOES_NOT_HOLD


@dataclass(frozen=True, eq=False)
class Statement:
    """A statement of the paper in other words, judged for one flank: its claims, what was `measure`d,
    and a sentence that says `why`."""

    id: str
    flank: str
    statement: str
    measure: str
    claims: tuple[Claim, ...]
    detail: str

    @property
    def verdict(self) -> Verdict:
        """Of the statement, from those of its claims."""
        verdicts = [claim.verdict for claim in self.claims]
        for worst in (Verdict.DOES_NOT_HOLD, Verdict.NOT_KNOWN, Verdict.DEPENDS):
            if worst in verdicts:
                return worst
        return Verdict.HOLDS

    @property
    def values(self) -> dict[str, Any]:
        """The numbers of all claims, and what each way of measuring says."""
        return {claim.text: {"numbers": claim.numbers, "holds": claim.holds} for claim in self.claims}

    @property
    def why(self) -> str:
        """One sentence: what holds, what does not, and the numbers."""
        lost = any(value is None for claim in self.claims for value in claim.holds.values())
        detail = "some of its paths are not on the flanks or have no such measure" if lost else self.detail
        return "; ".join([_said(claim) for claim in self.claims] + [detail]) + "."


def _said(claim: Claim) -> str:
    known = [value for value in claim.holds.values() if value is not None]
    if claim.verdict is Verdict.DEPENDS:
        against = next(name for name, value in claim.holds.items() if value is False)
        return f"{claim.text}: by {sum(known)} of {len(known)} measures, not by '{against}'"
    words = {Verdict.HOLDS: "yes", Verdict.DOES_NOT_HOLD: "no", Verdict.NOT_KNOWN: "not known"}
    return f"{claim.text}: {words[claim.verdict]}"


def claim_of(text: str, ways: dict[str, FloatArray], *tests: tuple[str, Test]) -> Claim:
    """A claim on numbers (n,) or (2 members, n), tested in one or more ways."""
    numbers: dict[str, FloatArray] = {}
    for name, values in ways.items():
        rows = (
            {name: values} if values.ndim == 1 else {f"{m}, {name}": values[j] for j, m in enumerate(MEMBERS)}
        )
        numbers |= rows
    holds: dict[str, bool | None] = {}
    for suffix, test in tests:
        for name, row in numbers.items():
            known = bool(np.isfinite(row).all())
            holds[f"{name}, {suffix}" if suffix else name] = bool(test(row)) if known else None
    return Claim(text, numbers, holds)


@dataclass(frozen=True)
class Case:
    """A design without modification and errors, one flank of it, and what several statements
    need. A `sign` of -1 takes all coefficients with the other sign."""

    design: Design
    flank: str
    sign: int = 1

    @cached_property
    def modified(self) -> Design:
        """The design with the coefficients MODIFIED."""
        return self.design.with_parabola(*(self.sign * value for value in MODIFIED))

    @cached_property
    def sweeps(self) -> dict[str, Sweep]:
        """Paths of C1 to C4."""
        ranges = {"C1": SMALL, "C2": SMALL, "C3": LARGE, "C4": LARGE}
        signs = {name: (self.sign * SIGNS[name][0], self.sign * SIGNS[name][1]) for name in ranges}
        return read_only(
            {name: sweep(self.design, self.flank, signs[name], size) for name, size in ranges.items()}
        )

    @cached_property
    def face(self) -> FloatArray:
        """Face widths (2, 1), mm."""
        return read_only(np.array([[float(member.face_width)] for member in self.design.members]))

    def ratios(self, name: str) -> dict[str, FloatArray]:
        """Contact ratios of a sweep, with and without toe and heel; NaN without a path."""
        size, signs, design = self.sweeps[name].size, self.sweeps[name].signs, self.design
        pinion, gear = (replace(m, face_width=WIDE * m.face_width) for m in design.members)
        wide = replace(design, pinion=pinion, gear=gear).with_parabola(signs[0] * size, signs[1] * size)
        ways = {
            "Eq. 16": self.sweeps[name].paths.contact_ratio,
            "Eq. 16 without toe and heel": contact_ratio(wide, self.flank),
        }
        return {way: np.where(ratio > 0.0, ratio, np.nan) for way, ratio in ways.items()}

    def both_shifts(self, error: str, size: float) -> dict[str, dict[str, FloatArray]]:
        """Shifts under -size and +size of an error, of the design and of the modified one."""
        return {
            "unmodified": shifts(self.design, self.flank, error, size),
            "modified": shifts(self.modified, self.flank, error, size),
        }


def grows(row: FloatArray) -> bool:
    """Whether numbers (n,) grow throughout."""
    return bool((np.diff(row) > 0.0).all())


def ends_greater(row: FloatArray) -> bool:
    """Whether the last number is greater than the first."""
    return bool(row[-1] > row[0])
