"""The command `beveloid-geom statements`."""

from __future__ import annotations

import click

from ... import results
from ...options import option

SIDES = click.Choice(["right", "left", "both"])


@results.result_command(
    option("--flank", SIDES, SIDES.choices[-1], "The paper's figures are of right flanks."),
    click.option(
        "--readings", is_flag=True, help="The verdicts alone, under other readings of the paper too."
    ),
    csv="one number a row, or one reading",
    units="mm, deg and rad as each measure says",
)
def statements(name: str, design: results.Design, flank: str, readings: bool) -> results.Result:
    """Judge the paper's statements on modified flanks and misaligned pairs.

    Each is computed for the DESIGN, whose own parabola coefficients and errors are set aside: holds,
    does not hold, depends on the measure, or not known, with the measures, their numbers and why.
    """
    from ....report.statements import ReadingsReport, StatementsReport

    flanks = ("right", "left") if flank == "both" else (flank,)
    if readings:
        from ....studies.statement_readings import verdicts_by_reading

        return ReadingsReport(name, {side: verdicts_by_reading(design, side) for side in flanks})
    from ....studies.statements import paper_statements

    judged = [one for side in flanks for one in paper_statements(design, side)]
    return StatementsReport(name, design, judged)
