"""The command `beveloid-geom sliding`."""

from __future__ import annotations

from ... import results
from ...options import flank_option, override_options, points_option


@results.result_command(
    flank_option, points_option(21, "along the path"), override_options, csv="one position per row"
)
def sliding(name: str, design: results.Design, flank: str, points: int) -> results.Result:
    """Compute sliding speed and specific sliding along the path of contact.

    Speeds are in mm per rad of pinion roll; multiplied by the pinion speed in rad/s they are in mm/s.
    Specific sliding is measured along the profile of each member. The total specific sliding is the sliding
    in all directions, divided by the distance that the contact moves on the flank. The exit status is 1
    without contact, 4 if the path could not be computed."""
    from ....report.sliding import sliding_report

    return sliding_report(name, design, flank, points)
