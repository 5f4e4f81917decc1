"""The command `beveloid-geom ease-off`."""

from __future__ import annotations

import click

from ... import results
from ...options import option, override_options

POINTS = "Points of the grid from root to tip, and along the face."


@results.result_command(
    option("--grid", (click.IntRange(3, 201), click.IntRange(3, 201)), (15, 21), POINTS, "PROFILE FACE"),
    override_options,
    csv="one point of a flank per row",
)
def ease_off(name: str, design: results.Design, grid: tuple[int, int]) -> results.Result:
    """Compute the ease-off of the pinion: the distance of its flanks from those conjugate to the gear.

    The ease-off is the distance along the normal of the pinion to the surface that the gear flank without
    tips and edges would generate at a constant ratio. It is positive where the flanks are apart, and 0 at the
    middle of the path of contact. For right and left flanks, with the parabolas of the design and without,
    the output has the corners and the coefficients of a fitted quadratic surface over face and profile (each
    from -1 to 1) with the rms of the residual. Exit status 1 if a flank has no path of contact, 4 if the path
    could not be computed."""
    from ....report.ease_off import ease_off_report

    with results.refused_values():
        return ease_off_report(name, design, grid)
