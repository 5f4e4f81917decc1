"""The command `beveloid-geom sensitivity`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ... import results
from ...options import flank_option, option, override_options

if TYPE_CHECKING:
    from ....design.model import ErrorsAt

AT = click.Choice(["perpendicular", "mesh"])
WHERE = (
    "Where errors are measured. Default: where the design has its own, the common perpendicular if not told."
)


@results.result_command(
    flank_option,
    option("--errors-at", AT, None, WHERE),
    override_options,
    csv="one quantity a row",
)
def sensitivity(name: str, design: results.Design, flank: str, errors_at: ErrorsAt | None) -> results.Result:
    """Find how path, contact ratio, transmission error and backlash answer the assembly errors.

    Derivatives by each error, exact, at the errors that the design has. Shifts are those of
    the middle of the path, positive towards the heel. Exit status 1 if there is no path on the flanks,
    or the pair cannot be assembled.
    """
    from ....report.sensitivity import sensitivity_report

    return sensitivity_report(name, design, flank, errors_at)
