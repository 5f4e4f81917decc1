"""The command `beveloid-geom operation`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ..options import NumberRange, flank_option, override_options, points_option
from ..results import result_command

if TYPE_CHECKING:
    from ...design.model import Design
    from ...report.result import Result


@result_command(
    flank_option,
    points_option(121, "over the cycle"),
    click.option(
        "--harmonics",
        type=click.IntRange(1, 200),
        default=10,
        show_default=True,
        help="Multiples of the mesh frequency.",
    ),
    click.option(
        "--film",
        type=NumberRange(0.0, 10.0),
        default=0.00635,
        show_default=True,
        metavar="MM",
        help="A second contact ratio counts tooth pairs within this clearance as touching, as if a film of "
        "that thickness lay between them.",
    ),
    override_options,
    csv="one position a row",
)
def operation(name: str, design: Design, flank: str, points: int, harmonics: int, film: float) -> Result:
    """Find transmission error and contact ratio of a pair in operation.

    At every roll of the pinion the first of all teeth touches, with its flank, its fillet or an
    edge; tooth pairs hand over to each other. One mesh cycle is solved, it repeats with the
    pinion's pitch. Rigid teeth, no load. Exit status 1 if a first contact is not
    known, or the pair cannot be assembled.
    """
    from ...findings.path import first_contact_fault
    from ...report.operation import operation_report

    if fault := first_contact_fault(design):
        raise click.ClickException(f"no first contact: {fault}")  # status 1
    return operation_report(name, design, flank, points, harmonics, film)
