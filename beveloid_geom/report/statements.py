"""The paper's statements as text: table, JSON and CSV of what the calculation says of them."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

from ..design.model import Design
from ..pair.mounting import mounting_of
from ..studies.statement_verdicts import Statement, Verdict
from .path import csv_text, json_text, layout_line

WIDTH = 100
Readings = Mapping[str, Mapping[str, Verdict]]
ANSWERS = {True: "yes", False: "no", None: ""}
LETTERS = {
    Verdict.HOLDS: "y",
    Verdict.DOES_NOT_HOLD: "-",
    Verdict.DEPENDS: "m",
    Verdict.NOT_KNOWN: "?",
}


def statements_json(statements: Sequence[Statement]) -> str:
    """Strict JSON: a list of the statements; values in mm, deg and shares, null where not known."""
    return json_text(
        [
            {
                "id": one.id,
                "flank": one.flank,
                "statement": one.statement,
                "verdict": one.verdict.value,
                "measure": one.measure,
                "values": one.values,
                "why": one.why,
            }
            for one in statements
        ]
    )


def statements_csv(statements: Sequence[Statement]) -> str:
    """CSV, a row for each number and for each answer of a way of measuring; `measure` names the units."""
    header = ["flank", "id", "verdict", "claim", "claim_verdict", "kind", "way", "position", "value"]
    header.append("measure")
    rows: list[tuple[object, ...]] = []
    for one in statements:
        for claim in one.claims:
            who = (one.flank, one.id, one.verdict.value, claim.text, claim.verdict.value)
            for way, numbers in claim.numbers.items():
                rows += [
                    (*who, "number", way, k, value, one.measure) for k, value in enumerate(numbers.tolist())
                ]
            rows += [
                (*who, "holds", way, "", ANSWERS[holds], one.measure) for way, holds in claim.holds.items()
            ]
    return csv_text(header, list(zip(*rows, strict=True)))


def statements_table(name: str, design: Design, statements: Sequence[Statement]) -> str:
    """Readable account of the statements, at most 100 characters wide."""
    text = f"Statements of Ni et al. (2017), computed for {name}\n"
    text += layout_line(design, mounting_of(design))
    for flank in dict.fromkeys(one.flank for one in statements):
        text += f"\n{flank} flanks\n"
        for one in statements:
            if one.flank == flank:
                text += _entry(one)
    return text


def _entry(one: Statement) -> str:
    lines = [f"  {one.id}  {one.verdict.value}"]
    for label, words in (
        ("says", one.statement),
        ("by", one.measure[0].upper() + one.measure[1:]),
        ("found", one.why[0].upper() + one.why[1:]),
    ):
        lines += textwrap.wrap(
            words,
            WIDTH,
            initial_indent=f"      {label:<6}",
            subsequent_indent=" " * 12,
            break_on_hyphens=False,
        )
    return "\n".join(lines) + "\n"


def readings_json(readings: Mapping[str, Readings]) -> str:
    """Strict JSON: verdicts by flank, reading and id of the statement."""
    return json_text(
        [
            {"flank": flank, "reading": name, "verdicts": {k: v.value for k, v in verdicts.items()}}
            for flank, by_name in readings.items()
            for name, verdicts in by_name.items()
        ]
    )


def readings_csv(readings: Mapping[str, Readings]) -> str:
    """CSV, one reading a row, a column for each statement."""
    rows = [
        (flank, name, *(verdict.value for verdict in verdicts.values()))
        for flank, by_name in readings.items()
        for name, verdicts in by_name.items()
    ]
    ids = next(iter(next(iter(readings.values())).values()))
    return csv_text(["flank", "reading", *ids], list(zip(*rows, strict=True)))


def readings_table(name: str, readings: Mapping[str, Readings]) -> str:
    """Readable account of the verdicts under each reading, at most 100 characters wide."""
    legend = ", ".join(f"{letter} {verdict.value}" for verdict, letter in LETTERS.items())
    text = f"Statements of Ni et al. (2017) under other readings of {name}\n  {legend}\n"
    for flank, by_name in readings.items():
        ids = list(next(iter(by_name.values())))
        text += f"\n  {flank + ' flanks':<42}" + "".join(f"{one:>3}" for one in ids) + "\n"
        for reading, verdicts in by_name.items():
            text += f"  {reading:<42}" + "".join(f"{LETTERS[verdicts[one]]:>3}" for one in ids) + "\n"
    return text
