"""Verdicts on the paper's statements: how they follow from claims and the ways to measure them.

A statement makes one or more claims. The paper's words can be measured in several ways
(`analysis.path_measures`), and each way gives its own answer, on pinion and gear. A statement holds if all
its claims hold in all ways; it does not hold if a claim holds in none; otherwise it depends on the
measure. Ways that give no number, as where a path has left the flanks, are left out; a claim with no
way left is not known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from ..arrays import FloatArray

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
    def count(self) -> tuple[int, int]:
        """In how many of the ways that are known it holds, and how many are known."""
        known = [value for value in self.holds.values() if value is not None]
        return sum(known), len(known)

    @property
    def verdict(self) -> Verdict:
        """Of the claim, from the ways that are known."""
        yes, known = self.count
        if not known:
            return Verdict.NOT_KNOWN
        return Verdict.DEPENDS if 0 < yes < known else Verdict.HOLDS if yes else Verdict.DOES_NOT_HOLD


@dataclass(frozen=True, eq=False)
class Statement:
    """A statement of the paper in other words, judged for one flank: where it stands (`source`), what was
    `measure`d, its claims, and the numbers in words (`detail`)."""

    id: str
    flank: str
    source: str
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
    if claim.verdict is Verdict.DEPENDS:
        against = next(name for name, value in claim.holds.items() if value is False)
        yes, known = claim.count
        return f"{claim.text}: by {yes} of {known} measures, not by '{against}'"
    words = {Verdict.HOLDS: "yes", Verdict.DOES_NOT_HOLD: "no", Verdict.NOT_KNOWN: "not known"}
    return f"{claim.text}: {words[claim.verdict]}"


def claim_of(text: str, ways: Mapping[str, FloatArray], asked: Test | Mapping[str, Test]) -> Claim:
    """Judge a claim on numbers (n,) or (2 members, n), tested in one way, or in several by their suffix."""
    numbers: dict[str, FloatArray] = {}
    for name, values in ways.items():
        both = (
            {f"{member}, {name}": row for member, row in zip(MEMBERS, values, strict=True)}
            if values.ndim > 1
            else {}
        )
        numbers |= both or {name: values}
    holds: dict[str, bool | None] = {}
    for suffix, test in (asked if isinstance(asked, Mapping) else {"": asked}).items():
        for name, row in numbers.items():
            known = bool(np.isfinite(row).all())
            holds[f"{name}, {suffix}" if suffix else name] = bool(test(row)) if known else None
    return Claim(text, numbers, holds)
