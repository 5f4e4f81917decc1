"""The command `beveloid-geom tca`."""

from __future__ import annotations

import click

from .. import results
from ..options import flank_option, option, override_options, points_option

CERTIFY = "Whether anything else of the teeth touches earlier, about a millisecond a position."
METHODS = click.Choice(["one-equation", "five-equation"])


@results.result_command(
    flank_option,
    points_option(101, "along the path"),
    override_options,
    option(
        "--method", METHODS, METHODS.choices[0], "The paper's five equations are slower, to compare with."
    ),
    click.option("--certify/--no-certify", default=True, show_default=True, help=CERTIFY),
    csv="one position a row",
)
def tca(
    name: str, design: results.Design, flank: str, points: int, method: str, certify: bool
) -> results.Result:
    """Find the path of contact of a pair of flanks.

    Rolls count from the position in which each member's generating rack is centred; z counts
    from mid-face towards the heel, l1 and l2 along the flank of the member's tool from its pitch line towards
    the member's tip.
    JSON and CSV give each position a status, and JSON the path: solved, no_common_normal, not_converged,
    off_flank, several_contacts, endless or undefined. Exit status 1 if there is no contact on the flanks,
    or the pair cannot be assembled.
    """
    from ...report.path import contact_report

    try:
        return contact_report(name, design, flank, points, method, certify)
    except ArithmeticError as error:
        raise click.ClickException(str(error)) from None  # status 1: nothing wrong with the input
