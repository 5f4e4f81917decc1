"""The command `beveloid-geom ease-off`."""

from __future__ import annotations

import click

from ... import results
from ...options import option, override_options

POINTS = "Points of the grid from root to tip and from toe to heel."


@results.result_command(
    option("--grid", (click.IntRange(3, 201), click.IntRange(3, 201)), (15, 21), POINTS, "PROFILE FACE"),
    override_options,
    csv="one point of a flank a row",
)
def ease_off(name: str, design: results.Design, grid: tuple[int, int]) -> results.Result:
    """Find the ease-off of the pinion: its flanks against the conjugate of the untrimmed mate.

    The distance along the pinion's normal, positive where the flanks part, to what the gear's flank without
    tips and edges would generate at the constant ratio; both touch in the middle of their path of contact.
    For right and left flanks, drive and coast, as given and without parabolas: corners, and the coefficients
    of the nearest surface of second order over face and profile, each from -1 to 1, with the rms of the rest.
    Exit status 1 if a flank has no path of contact.
    """
    from ....report.ease_off import ease_off_report

    with results.refused_values():
        return ease_off_report(name, design, grid)
