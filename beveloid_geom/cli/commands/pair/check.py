"""The command `beveloid-geom check`."""

from __future__ import annotations

from ... import results
from ...options import override_options


@results.result_command(override_options, csv="one quantity per row")
def check(name: str, design: results.Design) -> results.Result:
    """Check a design: contact on both flanks, backlash, teeth, edges.

    There is an error if the gears do not reach each other or overlap, if a flank has no contact, or if the
    pair cannot be assembled as mounted. Advice on the layout is printed only if a check of the changed design
    has confirmed it. There are warnings for contact that reaches an end of a face or is lost under usual
    assembly errors, edges that touch before the flanks, tips that reach below the active flank of the mate,
    undercut, pointed or thin teeth, tools with overlapping tip rounds, and lengths that are probably in
    inches. The exit status is 0 without errors, 1 with errors, 4 if something could not be computed and there
    are no errors."""
    from ....report.check import check_report

    return check_report(name, design)
