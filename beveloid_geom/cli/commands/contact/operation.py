"""The command `beveloid-geom operation`."""

from __future__ import annotations

import click

from ... import results
from ...options import NumberRange, flank_option, option, override_options, points_option

FILM = (
    "A second contact ratio counts tooth pairs within this clearance as touching, as if a film of that "
    "thickness lay between them."
)


@results.result_command(
    flank_option,
    points_option(121, "over the cycle"),
    option("--harmonics", click.IntRange(1, 200), 10, "Multiples of the mesh frequency."),
    option("--film", NumberRange(0.0, 10.0), 0.00635, FILM, "MM"),
    override_options,
    csv="one position a row",
)
def operation(
    name: str, design: results.Design, flank: str, points: int, harmonics: int, film: float
) -> results.Result:
    """Find transmission error and contact ratio of a pair in operation.

    At every roll of the pinion the first of all teeth touches, with its flank, its fillet or an
    edge; tooth pairs hand over to each other. One mesh cycle is solved, it repeats with the
    pinion's pitch. Rigid teeth, no load. Exit status 1 if a first contact is not
    known, or the pair cannot be assembled.
    """
    from ....findings.path import first_contact_fault
    from ....report.operation import operation_report

    if fault := first_contact_fault(design):
        raise click.ClickException(f"no first contact: {fault}")  # status 1
    return operation_report(name, design, flank, points, harmonics, film)
