"""The command `beveloid-geom pattern`."""

from __future__ import annotations

import click

from .. import results
from ..options import NumberRange, flank_option, option, override_options

POINTS = "Distance of the points on both flanks; areas do not depend on it.  [default: module / 15]"
ERROR = "Greatest error of an area, as a share of it, whatever the distance of the points."


@results.result_command(
    flank_option,
    option(
        "--separation",
        NumberRange(0.0, 10.0, min_open=True),
        0.00635,
        "Thickness of the marking compound.",
        "MM",
    ),
    option("--resolution", NumberRange(0.01, 100.0), None, POINTS, "MM"),
    option("--area-error", NumberRange(0.001, 0.5), 0.01, ERROR, "SHARE"),
    override_options,
    json=" of areas with their error and extent",
    csv="one point of a flank a row",
)
def pattern(
    name: str,
    design: results.Design,
    flank: str,
    separation: float,
    resolution: float | None,
    area_error: float,
) -> results.Result:
    """Find the contact pattern: where the flanks come within marking compound of each other.

    One tooth pair rolls through the mesh, the gear where the first of all teeth touches. Exit status 1
    if a first contact is not known, or the pair cannot be assembled.
    """
    from ...findings.path import first_contact_fault
    from ...operation.operating_rolls import UnknownOperationError
    from ...report.pattern import pattern_report

    if fault := first_contact_fault(design):
        raise click.ClickException(f"no pattern: {fault}")  # status 1
    try:
        with results.refused_values():
            return pattern_report(name, design, flank, separation, resolution, area_error)
    except UnknownOperationError as error:
        raise click.ClickException(f"no pattern: {error.reason}") from None  # status 1
