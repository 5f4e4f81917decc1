"""The command `beveloid-geom check`."""

from __future__ import annotations

from ... import results
from ...options import override_options


@results.result_command(override_options, csv="one quantity a row")
def check(name: str, design: results.Design) -> results.Result:
    """Say whether a design meshes and how well it closes: offset, shaft angle, backlash.

    Errors: gears that do not reach each other or run into each other, no contact on a flank, a pair
    that cannot be assembled as mounted; with advice that was tried first. Warnings: lines of action of
    right and left flanks that do not meet, contact that usual errors of assembly lose, edges that touch
    earlier, undercut, pointed teeth, tools whose rounds overlap. Exit status 0 with or without them.
    """
    from ....report.closing import closing_report

    return closing_report(name, design)
