"""The command `beveloid-geom check`."""

from __future__ import annotations

from ... import results
from ...options import override_options


@results.result_command(override_options, csv="one quantity per row")
def check(name: str, design: results.Design) -> results.Result:
    """Check a design: contact on both flanks, backlash, teeth, edges.

    Errors: gears that do not reach each other or overlap, no contact on a flank, a pair that cannot be
    assembled as mounted; with advice that has been verified. Warnings: contact that reaches an end of a face
    or is lost under usual assembly errors, edges that touch earlier, tips below the active flank of the mate,
    undercut, pointed or thin teeth, tools with overlapping tip rounds, lengths that are probably in inches.
    Exit status 0 without errors, 1 with errors, 4 if something could not be computed and there are no errors.
    """
    from ....report.check import check_report

    return check_report(name, design)
