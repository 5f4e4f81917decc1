"""The command `beveloid-geom sliding`."""

from __future__ import annotations

from ... import results
from ...options import flank_option, override_options, points_option


@results.result_command(
    flank_option, points_option(21, "along the path"), override_options, csv="one position a row"
)
def sliding(name: str, design: results.Design, flank: str, points: int) -> results.Result:
    """Find sliding speed and specific sliding along the path of contact.

    Speeds are in mm per rad of the pinion's roll: times its speed in rad/s they are in mm/s. Specific
    sliding is that along each member's profile; the total counts sliding in all directions, per
    distance that the contact runs over the member's flank. Exit status 1 without contact.
    """
    from ....report.sliding import sliding_report

    return sliding_report(name, design, flank, points)
