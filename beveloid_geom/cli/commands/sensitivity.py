"""The command `beveloid-geom sensitivity`."""

from __future__ import annotations

from .. import results
from ..options import flank_option, override_options


@results.result_command(flank_option, override_options, csv="one quantity a row")
def sensitivity(name: str, design: results.Design, flank: str) -> results.Result:
    """Find how path, contact ratio, transmission error and backlash answer the assembly errors.

    Derivatives by each of the four errors, exact, at the errors that the design has. Shifts are those of
    the middle of the path, positive towards the heel. Exit status 1 if there is no path on the flanks,
    or the pair cannot be assembled.
    """
    from ...report.sensitivity import sensitivity_report

    return sensitivity_report(name, design, flank)
