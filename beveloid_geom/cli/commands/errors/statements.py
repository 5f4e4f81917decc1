"""The command `beveloid-geom statements`."""

from __future__ import annotations

import click

from ... import results
from ...options import option


@results.result_command(
    option(
        "--flank",
        click.Choice(["right", "left", "both"]),
        "right",
        "Flanks of the design. The paper does not say which flanks its figures show: we infer right"
        " flanks; left flanks are for comparison only.",
    ),
    csv="one number per row",
    units="mm, deg and rad as given by each measure",
)
def statements(name: str, design: results.Design, flank: str) -> results.Result:
    """Check the statements of the paper on modified flanks and misaligned pairs.

    Each statement is computed for the DESIGN without its parabola coefficients, modifications and errors. The
    verdict is: holds, does not hold, depends on the measure, or not known. Measures, numbers and reasons are
    printed."""
    from ....report.statements import StatementsReport
    from ....validation.statements import paper_statements

    flanks = ("right", "left") if flank == "both" else (flank,)
    judged = [one for side in flanks for one in paper_statements(design, side)]
    return StatementsReport(name, design, judged)
