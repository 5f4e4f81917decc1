"""Verdicts on the paper's statements, derived from their claims.

A statement consists of one or more claims. A claim can be measured in several ways
(`analysis.path_measures`), on pinion and gear, and each measure gives an answer. A statement holds if all
claims hold by all measures. It does not hold if a claim holds by no measure. Measures without a value, for
example of a path that has left the flanks, are ignored. A claim without any value is not known; then the
statement is not known either, unless another claim does not hold. Otherwise the statement depends on the
measure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from ..arrays import MEMBERS, FloatArray

Test = Callable[[FloatArray], bool]


class StatementVerdict(Enum):
    """Verdict on a claim or a statement."""

    HOLDS = "holds"
    DOES_NOT_HOLD = "does not hold"
    DEPENDS = "depends on the measure"
    NOT_KNOWN = "not known"


@dataclass(frozen=True, eq=False)
class Claim:
    """One claim of a statement: the `numbers` (n,) and whether it `holds` by the names of the measures; None
    if a number is not known."""

    text: str
    numbers: dict[str, FloatArray]
    holds: dict[str, bool | None]

    @property
    def count(self) -> tuple[int, int]:
        """Number of measures by which the claim holds, and number of known measures."""
        known = [value for value in self.holds.values() if value is not None]
        return sum(known), len(known)

    @property
    def verdict(self) -> StatementVerdict:
        """Verdict on the claim from the known measures."""
        yes, known = self.count
        if not known:
            return StatementVerdict.NOT_KNOWN
        if 0 < yes < known:
            return StatementVerdict.DEPENDS
        return StatementVerdict.HOLDS if yes else StatementVerdict.DOES_NOT_HOLD


@dataclass(frozen=True, eq=False)
class Statement:
    """A statement of the paper, judged for one flank.

    `source` is the figure or section of the paper, `statement` its content in our words, `measure` the
    description of the measures, and `detail` a sentence with the numbers."""

    id: str
    flank: str
    source: str
    statement: str
    measure: str
    claims: tuple[Claim, ...]
    detail: str

    @property
    def verdict(self) -> StatementVerdict:
        """Verdict on the statement from the verdicts on its claims."""
        verdicts = [claim.verdict for claim in self.claims]
        for worst in (StatementVerdict.DOES_NOT_HOLD, StatementVerdict.NOT_KNOWN, StatementVerdict.DEPENDS):
            if worst in verdicts:
                return worst
        return StatementVerdict.HOLDS

    @property
    def values(self) -> dict[str, Any]:
        """Numbers and answers of all measures, by claim."""
        return {claim.text: {"numbers": claim.numbers, "holds": claim.holds} for claim in self.claims}

    @property
    def why(self) -> str:
        """Sentence with the answers of all claims and the numbers."""
        lost = any(value is None for claim in self.claims for value in claim.holds.values())
        detail = "some of its paths are not on the flanks or have no such measure" if lost else self.detail
        return "; ".join([_answer(claim) for claim in self.claims] + [detail]) + "."


def _answer(claim: Claim) -> str:
    if claim.verdict is StatementVerdict.DEPENDS:
        against = next(name for name, value in claim.holds.items() if value is False)
        yes, known = claim.count
        return f"{claim.text}: by {yes} of {known} measures, not by '{against}'"
    words = {
        StatementVerdict.HOLDS: "yes",
        StatementVerdict.DOES_NOT_HOLD: "no",
        StatementVerdict.NOT_KNOWN: "not known",
    }
    return f"{claim.text}: {words[claim.verdict]}"


def claim_of(text: str, measures: Mapping[str, FloatArray], criteria: Test | Mapping[str, Test]) -> Claim:
    """Return a claim judged on values (n,) or (2 members, n) by one criterion, or by several criteria with
    names."""
    numbers: dict[str, FloatArray] = {}
    for name, values in measures.items():
        both = (
            {f"{member}, {name}": row for member, row in zip(MEMBERS, values, strict=True)}
            if values.ndim > 1
            else {}
        )
        numbers |= both or {name: values}
    holds: dict[str, bool | None] = {}
    for suffix, test in (criteria if isinstance(criteria, Mapping) else {"": criteria}).items():
        for name, row in numbers.items():
            known = bool(np.isfinite(row).all())
            holds[f"{name}, {suffix}" if suffix else name] = bool(test(row)) if known else None
    return Claim(text, numbers, holds)
