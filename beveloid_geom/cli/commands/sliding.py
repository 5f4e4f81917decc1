"""The command `beveloid-geom sliding`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..options import flank_option, override_options, points_option
from ..results import result_command

if TYPE_CHECKING:
    from ...design.model import Design
    from ...report.result import Result


@result_command(flank_option, points_option(21, "along the path"), override_options, csv="one position a row")
def sliding(name: str, design: Design, flank: str, points: int) -> Result:
    """Find sliding speed and specific sliding along the path of contact.

    Speeds are in mm per rad of the pinion's roll: times its speed in rad/s they are in mm/s. Specific
    sliding is that along each member's profile; the total counts sliding in all directions, per
    distance that the contact runs over the member's flank. Exit status 1 without contact.
    """
    from ...report.sliding import sliding_report

    return sliding_report(name, design, flank, points)
