"""The command `beveloid-geom ease-off`."""

from __future__ import annotations

import click

from ... import results
from ...options import option, override_options


@results.result_command(
    option(
        "--grid",
        (click.IntRange(3, 201), click.IntRange(3, 201)),
        (15, 21),
        "Number of points of the grid from root to tip, and along the face.",
        "PROFILE FACE",
    ),
    override_options,
    csv="one point of a flank per row",
)
def ease_off_command(name: str, design: results.Design, grid: tuple[int, int]) -> results.Result:
    """Compute the ease-off of the pinion: the distance of its flanks from flanks that are conjugate to the
    gear.

    The ease-off is measured along the normal of the pinion flank. The conjugate flank is the surface that the
    gear flank, extended beyond its edges, generates at a constant ratio. The ease-off is positive where the
    flanks are apart, and 0 at the middle of the path of contact. The output contains right and left flanks,
    with the parabolas of the design and without. For each it has the values at the corners, the coefficients
    of a fitted quadratic surface over face and profile (each from -1 to 1), and the rms of the residual. The
    exit status is 1 if a flank has no path of contact, 4 if the path could not be computed."""
    from ....report.ease_off import ease_off_report

    with results.refused_values():
        return ease_off_report(name, design, grid)
