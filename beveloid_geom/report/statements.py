"""The paper's statements: what the calculation says of them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..design.model import Design
from ..findings.layout import bare
from ..studies.statement_verdicts import Statement, Verdict
from .result import Rows, by_columns
from .words import WIDTH, head_lines

Readings = Mapping[str, Mapping[str, Verdict]]
"""Verdicts by reading and id of the statement."""
ANSWERS = {True: "yes", False: "no", None: ""}
LETTERS = {
    Verdict.HOLDS: "y",
    Verdict.DOES_NOT_HOLD: "-",
    Verdict.DEPENDS: "m",
    Verdict.NOT_KNOWN: "?",
}


@dataclass(frozen=True, eq=False)
class StatementsReport:
    """The `statements` as judged for a single design."""

    name: str
    design: Design
    statements: Sequence[Statement]
    failure: str | None = None

    def data(self) -> list[dict[str, Any]]:
        """Give the statements; values in mm, deg and shares, as the measure says."""
        keys = ("id", "flank", "statement", "measure", "values", "why")
        return [
            {**{key: getattr(one, key) for key in keys}, "verdict": one.verdict.value}
            for one in self.statements
        ]

    def rows(self) -> Rows:
        """Give each number and each answer of a way of measuring; `measure` names the units."""
        names = ("flank", "id", "verdict", "claim", "claim_verdict", "kind", "way", "position", "value")
        return by_columns((*names, "measure"), list(self._rows()))

    def _rows(self) -> Iterator[tuple[Any, ...]]:
        for one in self.statements:
            for claim in one.claims:
                who = (one.flank, one.id, one.verdict.value, claim.text, claim.verdict.value)
                for way, numbers in claim.numbers.items():
                    for k, value in enumerate(numbers.tolist()):
                        yield *who, "number", way, k, value, one.measure
                for way, holds in claim.holds.items():
                    yield *who, "holds", way, "", ANSWERS[holds], one.measure

    def summary(self) -> str:
        """Write each statement with its verdict, measure and reason."""
        text = f"Statements of Ni et al. (2017), computed for {self.name}\n"
        text += head_lines(bare(self.design))
        for flank in dict.fromkeys(one.flank for one in self.statements):
            own = (_entry(one) for one in self.statements if one.flank == flank)
            text += f"\n{flank} flanks\n" + "".join(own)
        return text


def _entry(one: Statement) -> str:
    lines = [f"  {one.id}  {one.verdict.value}"]
    said = {"says": one.statement, "by": one.measure, "found": one.why}
    for label, words in said.items():
        lines += textwrap.wrap(
            words if words[1].isdigit() else words[0].upper() + words[1:],  # a1 stays
            WIDTH,
            initial_indent=f"      {label:<6}",
            subsequent_indent=" " * 12,
            break_on_hyphens=False,
        )
    return "\n".join(lines) + "\n"


@dataclass(frozen=True, eq=False)
class ReadingsReport:
    """Verdicts on the statements by flank under each of the `readings` of the paper."""

    name: str
    readings: Mapping[str, Readings]
    failure: str | None = None

    def data(self) -> list[dict[str, Any]]:
        """Give the verdicts by flank, reading and id of the statement."""
        return [
            {"flank": flank, "reading": reading, "verdicts": {k: v.value for k, v in verdicts.items()}}
            for flank, by_name in self.readings.items()
            for reading, verdicts in by_name.items()
        ]

    def rows(self) -> Rows:
        """Give the readings, a column for each statement."""
        rows = [(one["flank"], one["reading"], *one["verdicts"].values()) for one in self.data()]
        return by_columns(("flank", "reading", *self.data()[0]["verdicts"]), rows)

    def summary(self) -> str:
        """Write a letter for each verdict."""
        legend = ", ".join(f"{letter} {verdict.value}" for verdict, letter in LETTERS.items())
        text = f"Statements of Ni et al. (2017) under other readings of {self.name}\n  {legend}\n"
        for flank, by_name in self.readings.items():
            ids = list(next(iter(by_name.values())))
            text += f"\n  {flank + ' flanks':<42}" + "".join(f"{one:>3}" for one in ids) + "\n"
            for reading, verdicts in by_name.items():
                text += f"  {reading:<42}" + "".join(f"{LETTERS[verdicts[one]]:>3}" for one in ids) + "\n"
        return text
