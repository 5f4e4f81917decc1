"""Report of `statements`: verdicts on the statements of the paper."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ..design.ends import end_names
from ..validation.statement_verdicts import Statement
from .result import Report, Rows, by_columns
from .text import LINE_WIDTH, head_lines, line


@dataclass(frozen=True, eq=False)
class StatementsReport(Report):
    """The `statements` as judged for a single design."""

    statements: Sequence[Statement]

    def data(self) -> list[dict[str, Any]]:
        """Return the statements; the measure gives the units of the values (mm, deg, shares)."""
        keys = ("id", "flank", "statement", "measure", "values", "why")
        return [
            {**{key: getattr(statement, key) for key in keys}, "verdict": statement.verdict.value}
            for statement in self.statements
        ]

    def rows(self) -> Rows:
        """Return each number and each answer of a measure; the column `measure` gives the units."""
        names = ("flank", "id", "verdict", "claim", "claim_verdict", "kind", "way", "position", "value")
        return by_columns((*names, "measure"), list(self._rows()))

    def _rows(self) -> Iterator[tuple[Any, ...]]:
        """Yield the rows: numbers and answers of each claim of each statement."""
        answers = {True: "yes", False: "no", None: ""}
        for one in self.statements:
            for claim in one.claims:
                start = (one.flank, one.id, one.verdict.value, claim.text, claim.verdict.value)
                for name, numbers in claim.numbers.items():
                    for k, value in enumerate(numbers.tolist()):
                        yield *start, "number", name, k, value, one.measure
                for name, holds in claim.holds.items():
                    yield *start, "holds", name, "", answers[holds], one.measure

    def summary(self) -> str:
        """Return each statement with verdict, measure and reason."""
        # Meaning of the verdicts for each flank.
        role = {
            "right": ", which we infer to be those of the paper's figures",
            "left": ", for comparison, not a judgement of the paper",
        }
        text = f"Statements of Ni et al. (2017), computed for {self.name}\n"
        text += head_lines(self.design.bare())
        if end_names(self.design.pinion) != ("toe", "heel"):
            text += line("ends", "the paper's toe and heel are the ends of the face at -z and +z")
        for flank in dict.fromkeys(statement.flank for statement in self.statements):
            entries = (_entry(statement) for statement in self.statements if statement.flank == flank)
            text += f"\n{flank} flanks{role[flank]}\n" + "".join(entries)
        return text


def _entry(statement: Statement) -> str:
    """Return the lines on one statement."""
    lines = [f"  {statement.id}  {statement.verdict.value}"]
    parts = {"paper": statement.statement, "measure": statement.measure, "result": statement.why}
    for label, words in parts.items():
        lines += textwrap.wrap(
            words if words[1].isdigit() else words[0].upper() + words[1:],  # a1 stays
            LINE_WIDTH,
            initial_indent=f"      {label:<8}",
            subsequent_indent=" " * 14,
            break_on_hyphens=False,
        )
    return "\n".join(lines) + "\n"
