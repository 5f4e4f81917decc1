"""The command `beveloid-geom map`."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable

import click

from .options import (
    BUILTIN_DESIGN,
    Command,
    Refusal,
    changed_design,
    error_sizes,
    flank_option,
    load_design,
    override_options,
    require_one_format,
    write_out,
)


def _bounds(option: str, text: str) -> Callable[[Command], Command]:
    help_text = f"Least and greatest value of the {text}: 1/mm, mm, or a coefficient. Default: usual ones."
    return click.option(option, type=(float, float), metavar="LOW HIGH", help=help_text)


@click.command("map")
@click.argument("design", default=BUILTIN_DESIGN)
@click.option(
    "--over",
    type=click.Choice(["parabola", "mounting", "shift"]),
    default="parabola",
    show_default=True,
    help="Parabola coefficients, changes of the mounting distances, or profile shift coefficients.",
)
@flank_option
@_bounds("--pinion-bounds", "pinion")
@_bounds("--gear-bounds", "gear")
@click.option(
    "--steps", type=click.IntRange(2, 201), default=21, show_default=True, help="Values of each member."
)
@error_sizes("Error")
@click.option(
    "--first-contacts",
    is_flag=True,
    help="Also the share of a mesh cycle at which flanks touch first; about 50 ms a cell.",
)
@override_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON, mm and rad.")
@click.option("--csv", "as_csv", is_flag=True, help="Print CSV, one cell a row, mm and rad.")
@click.pass_context
def map_command(
    context: click.Context,
    /,
    design: str,
    over: str,
    flank: str,
    pinion_bounds: tuple[float, float] | None,
    gear_bounds: tuple[float, float] | None,
    steps: int,
    offset: float,
    shaft_angle_deg: float,
    pinion_axial: float,
    gear_axial: float,
    first_contacts: bool,
    as_json: bool,
    as_csv: bool,
    **changes: float | None,
) -> None:
    """Contact ratio, angle, shift and transmission error over two values of a design.

    The shift of the path is that under assembly errors, the usual tolerances unless some are given. The
    table has the extremes and where they are, JSON and CSV have every cell; `render-figures --only
    map-parabola` and its like draw them. Some seconds, minutes at 201 steps
    or near line contact. Exit status 1 if no cell
    has a path.
    """
    require_one_format(as_json, as_csv)
    for member in ("pinion", "gear") if over == "parabola" else ():
        if changes[f"parabola_{member}"] is not None:
            cure = f"give --{member}-bounds, or another --over"
            raise Refusal([f"--parabola-{member}: the map itself is over the parabola coefficients: {cure}"])
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its products are too small to be shared out
    changed = changed_design(load_design(design), changes)
    from tqdm import tqdm

    from ..analysis.maps import OVER, map_of
    from ..design.model import Errors
    from ..report import map as report

    sizes = Errors(offset, math.radians(shaft_angle_deg), pinion_axial, gear_axial)
    name = click.format_filename(design)
    try:
        with tqdm(total=steps**2, desc="cells", unit="cell", file=sys.stderr, disable=None) as bar:
            found = map_of(
                changed,
                next(known for known in OVER if known == over),
                flank,
                pinion=pinion_bounds,
                gear=gear_bounds,
                steps=steps,
                errors=sizes if any(vars(sizes).values()) else None,
                first_contacts=first_contacts,
                progress=bar.update,
            )
    except ValueError as error:
        raise Refusal([str(error)]) from None
    if as_json:
        write_out(report.map_json(name, found))
    else:
        write_out(report.map_csv(found) if as_csv else report.map_table(name, found))
    if not found.solved.any():
        click.echo(f"No contact: no cell of the map has a path on the {flank} flanks", err=True)
        context.exit(1)
