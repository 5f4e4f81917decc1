"""The command `beveloid-geom sensitivity`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..options import flank_option, override_options
from ..results import result_command

if TYPE_CHECKING:
    from ...design.model import Design
    from ...report.result import Result


@result_command(flank_option, override_options, csv="one quantity a row")
def sensitivity(name: str, design: Design, flank: str) -> Result:
    """Find how path, contact ratio, transmission error and backlash answer the assembly errors.

    Derivatives by each of the four errors, exact, at the errors that the design has. Shifts are those of
    the middle of the path, positive towards the heel. Exit status 1 if there is no path on the flanks,
    or the pair cannot be assembled.
    """
    from ...report.sensitivity import sensitivity_report

    return sensitivity_report(name, design, flank)
