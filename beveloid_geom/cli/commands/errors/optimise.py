"""The command `beveloid-geom optimise`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

from ... import results
from ...options import (
    Refusal,
    bounds_options,
    errors_of,
    flank_option,
    option,
    renamed,
    sizes_of,
    tolerance_options,
)

if TYPE_CHECKING:
    from ....analysis.maps import Bounds


EDGES = (
    "No edge carries any of a mesh cycle, neither as designed nor under an error, each alone and both ways."
)
ERROR = "Greatest transmission error of the path, peak to peak. Default: any."
SHIFT = "Greatest shift of the path under the errors. Default: any."
LEAST = "What is to be least: that shift or, with --no-edges, the error of all teeth under any of the errors."
LEASTS = click.Choice(["shift", "transmission-error"])


@results.result_command(
    flank_option,
    tolerance_options,
    option("--least", LEASTS, LEASTS.choices[0], LEAST),
    option("--contact-ratio", float, 1.6, "Contact ratio (Eq. 16) to be reached.", "RATIO"),
    option("--off-centre", float, 1.0, "How far the middle of the path may lie from mid-face.", "MM"),
    option("--transmission-error-arcsec", float, math.inf, ERROR, "ARCSEC"),
    renamed("--transmission-error", "--transmission-error-arcsec"),
    option("--shift", float, math.inf, SHIFT, "MM"),
    bounds_options("Least and greatest coefficient of the {}'s tool, 1/mm.", (-0.002, 0.002)),
    click.option("--no-edges", is_flag=True, help=EDGES),
    csv="a row each for found and given",
)
def optimise(
    name: str,
    design: results.Design,
    flank: str,
    least: str,
    contact_ratio: float,
    off_centre: float,
    transmission_error_arcsec: float,
    shift: float,
    pinion_bounds: Bounds,
    gear_bounds: Bounds,
    no_edges: bool,
    **tolerances: float,
) -> results.Result:
    """Find the parabola coefficients with which errors shift the path of contact least, or all teeth run most
    evenly.

    The path keeps a contact ratio, stays centred on the face, and the flanks are not hollow against
    each other; with --no-edges no edge touches first either. The errors are as large as their tolerances,
    of which at least one is given; some seconds. Exit status 2 if nothing meets the aim.
    """
    sizes = sizes_of(tolerances, "errors that shift the path")
    if least != LEASTS.choices[0] and not no_edges:
        raise Refusal(
            [f"--least {least}: it is that of teeth whose edges do not carry: give --no-edges, too"]
        )
    from ....analysis.optimise import Aim, optimise_parabola
    from ....report.aims import OptimumReport

    swing = math.radians(transmission_error_arcsec / 3600.0)
    aim = Aim(
        errors=errors_of(sizes),
        contact_ratio=contact_ratio,
        off_centre=off_centre,
        peak_to_peak=swing,
        pinion_parabola=pinion_bounds,
        gear_parabola=gear_bounds,
        edges=not no_edges,
        shift=shift,
        least="shift" if least == LEASTS.choices[0] else "transmission_error",
    )
    with results.refused_values():
        return OptimumReport(name, design, aim, flank, optimise_parabola(design, aim, flank))
