"""The command `beveloid-geom map`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from ... import results
from ...options import (
    Refusal,
    bounds_options,
    errors_of,
    flank_option,
    option,
    override_options,
    progress_bar,
    sizes_of,
    tolerance_options,
)

if TYPE_CHECKING:
    from ....analysis.maps import Bounds, Over


VALUES = click.Choice(["parabola", "mounting", "shift"])
OVER = "Parabola coefficients, changes of the mounting distances, or profile shift coefficients."
OPERATION = "Also what all teeth do in operation: transmission error, edges; 20 to 30 ms a cell more."


@results.result_command(
    option("--over", VALUES, VALUES.choices[0], OVER),
    flank_option,
    bounds_options("Least and greatest value of the {}: 1/mm, mm, or a coefficient. Default: usual ones."),
    option("--steps", click.IntRange(2, 201), 21, "Values of each member."),
    tolerance_options,
    click.option("--operation", is_flag=True, help=OPERATION),
    override_options,
    csv="one cell a row",
)
def map_(
    name: str,
    design: results.Design,
    over: Over,
    flank: str,
    pinion_bounds: Bounds | None,
    gear_bounds: Bounds | None,
    steps: int,
    operation: bool,
    **tolerances: float,
) -> results.Result:
    """Find contact ratio, angle, shift and transmission error over two values of a design.

    The shift of the path is that under assembly errors as large as their tolerances, usual ones unless
    some are given. The text has the extremes and where they are, JSON and CSV have every cell;
    `render-figures --only map-parabola` and its like draw them. Some seconds, minutes at 201 steps
    or near line contact. Exit status 1 if no cell has a path.
    """
    context = click.get_current_context()
    for member in ("pinion", "gear") if over == "parabola" else ():
        if context.get_parameter_source(f"parabola_{member}") is ParameterSource.COMMANDLINE:
            cure = f"give --{member}-bounds, or another --over"
            raise Refusal([f"--parabola-{member}: the map itself is over the parabola coefficients: {cure}"])
    from ....analysis.maps import map_of
    from ....report.map import MapReport

    errors = errors_of(sizes_of(tolerances)) if any(tolerances.values()) else None
    with results.refused_values(), progress_bar(steps**2, "cell") as bar:
        found = map_of(
            design,
            over,
            flank,
            pinion=pinion_bounds,
            gear=gear_bounds,
            steps=steps,
            errors=errors,
            operation=operation,
            progress=bar.update,
        )
    return MapReport(name, found)
