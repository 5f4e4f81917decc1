"""The command `beveloid-geom operation`."""

from __future__ import annotations

import click

from ... import results
from ...options import NumberRange, flank_option, no_result, option, override_options, points_option


@results.result_command(
    flank_option,
    points_option(121, "over the cycle"),
    option("--harmonics", click.IntRange(1, 200), 10, "Number of harmonics of the mesh frequency."),
    option(
        "--film",
        NumberRange(0.0, 10.0),
        0.00635,
        "Film thickness (lubricant or marking compound) for a second contact ratio. Tooth pairs whose"
        " clearance exceeds that of the first pair by at most this value count as in contact.",
        "MM",
    ),
    override_options,
    csv="one position per row",
    each_tooth=True,
)
def operation(
    name: str, design: results.Design, flank: str, points: int, harmonics: int, film: float
) -> results.Result:
    """Compute transmission error and contact ratio of a pair in operation.

    At each roll angle of the pinion, the tooth pair that touches first is in contact, at its flanks, a fillet
    or an edge. The number of this pair is printed. The transmission error is positive where the gear is
    ahead. The mesh cycle repeats with the pitch of the pinion; deviations of single teeth are evaluated over
    all pairs of teeth. Teeth are rigid and without load. The exit status is 1 if there is no contact or the
    pair cannot be assembled, 4 if the cycle or a contact ratio could not be computed."""
    from ....findings.path import first_contact_fault
    from ....report.operation import operation_report

    if fault := first_contact_fault(design):
        raise no_result(fault)
    with results.refused_values():
        return operation_report(name, design, flank, points, harmonics, film)
