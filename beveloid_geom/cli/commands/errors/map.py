"""The command `beveloid-geom map`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ... import results
from ...options import (
    MEMBERS,
    PARABOLAS,
    Refusal,
    bounds_options,
    flank_option,
    given_options,
    option,
    override_options,
    progress_bar,
)
from ...tolerance_options import errors_of, sizes_of, tolerance_names, tolerance_options

if TYPE_CHECKING:
    from ....pair.named_inputs import Bounds


@results.result_command(
    option(
        "--over",
        str,
        "parabola",
        "parabola (coefficients), mounting (changes of the mounting distances), shift (profile shift"
        " coefficients), or two inputs such as offset,shaft_angle (or E,Sigma: the values of the layout, not"
        " assembly errors); an unknown name lists all inputs.",
        "INPUTS",
    ),
    flank_option,
    bounds_options(
        "Lower and upper limit of the quantity of the {}: 1/mm, mm, rad, or no unit for profile shifts. If"
        " --over names two inputs, --pinion-bounds is for the first and --gear-bounds for the second."
        " Required for inputs without a usual range, such as offset."
    ),
    option("--steps", click.IntRange(2, 201), 21, "Number of values of each input."),
    tolerance_options,
    click.option(
        "--operation",
        is_flag=True,
        help="Also compute transmission error and edge contact in operation; this takes 20 to 30 ms more per"
        " cell.",
    ),
    override_options,
    csv="one cell per row",
)
def map_(
    name: str,
    design: results.Design,
    over: str,
    flank: str,
    pinion_bounds: Bounds | None,
    gear_bounds: Bounds | None,
    steps: int,
    operation: bool,
    **tolerances: float | None,
) -> results.Result:
    """Compute contact ratio, angle, shift and transmission error over two quantities of a design.

    The shift is the movement of the middle of the path, perpendicular to the path, under errors that are as
    large as their tolerances (if none is given, the usual tolerances of the command `tolerance`).
    Each error is applied alone and in both directions. The squared movements, in the plane of z and l1 of the
    pinion (l1 is the position along its tool flank), are averaged over both directions and added for all
    errors; the shift is the root of this sum. The angle is that between the chord of the path and the axial
    direction, in the side view (z against radius r). The normal backlash is without parabolas, modifications
    and errors, the mounted backlash with them. The mounted backlash is that of the flanks without edge
    contact, as in `tolerance`; `check` and `operation` include edges, which can touch earlier. Where it is
    unknown, the cell is empty and `jammed` is 0.

    The text lists the extremes and their positions, JSON and CSV contain every cell. `render-figures --only
    map-parabola` draws the map. The calculation takes some seconds, and minutes for 201 steps or near line
    contact. The exit status is 1 if no cell has a path, 4 if no path was found and not all could be
    computed."""
    if over == "parabola":
        coefficients = (name for name, *_ in PARABOLAS if not name.startswith("parabola_apex"))
        for given in given_options(coefficients):
            cure = f"give --{given.rpartition('-')[2]}-bounds, or another --over"
            reason = "cannot be given, as the map is over the parabola coefficients"
            raise Refusal([f"{given} {reason}: {cure}"])
    from ....analysis.maps import design_map
    from ....pair.named_inputs import bounds_argument, inputs_of
    from ....report.map import MapReport

    symbols = {"e": "offset", "sigma": "shaft_angle"}
    words = (word.strip() for word in over.replace("-", "_").partition(","))
    first, comma, second = (symbols.get(word.lower(), word) for word in words)
    inputs = (first, second) if comma else over
    errors = errors_of(sizes) if (sizes := sizes_of(tolerances)) else None
    with results.refused_values():
        names = map(bounds_argument, inputs_of(inputs))
    # Such as --gear-bounds of shaft_angle.
    options = {argument: f"--{member}-{argument}" for member, argument in zip(MEMBERS, names, strict=True)}
    options |= tolerance_names("error of")
    with results.refused_values(options), progress_bar(steps**2, "cell") as bar:
        result = design_map(
            design,
            inputs,
            flank,
            first=pinion_bounds,
            second=gear_bounds,
            steps=steps,
            errors=errors,
            operation=operation,
            progress=bar.update,
        )
    return MapReport(name, design, result)
