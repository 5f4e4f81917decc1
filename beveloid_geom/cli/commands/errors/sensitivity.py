"""The command `beveloid-geom sensitivity`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ... import results
from ...options import flank_option, option, override_options

if TYPE_CHECKING:
    from ....design.model import ErrorsAt


@results.result_command(
    flank_option,
    option(
        "--errors-at",
        click.Choice(["perpendicular", "mesh"]),
        None,
        "perpendicular: errors of offset, shaft angle and axial positions, about the common perpendicular."
        " mesh: errors of centre distance, both tilts and axial positions, about the pitch point. Default:"
        " as in the design.",
    ),
    override_options,
    csv="one quantity per row",
)
def sensitivity(name: str, design: results.Design, flank: str, errors_at: ErrorsAt | None) -> results.Result:
    """Compute the derivatives of path, contact ratio, transmission error and backlash with respect to the
    assembly errors.

    The derivatives are exact and evaluated at the errors of the design. Where a derivative does not exist,
    the table has a dash and the line "no derivatives" gives the reason. Movements are those of the middle of
    the path, positive towards +z. The exit status is 1 if there is no path on the flanks or the pair cannot
    be assembled, 4 if the path could not be computed."""
    from ....report.sensitivity import sensitivity_report

    return sensitivity_report(name, design, flank, errors_at)
