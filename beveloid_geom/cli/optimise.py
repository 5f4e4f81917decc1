"""The command `beveloid-geom optimise`."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

import click

from .options import (
    BUILTIN_DESIGN,
    Command,
    Refusal,
    error_sizes,
    flank_option,
    load_design,
    require_one_format,
    require_sizes,
    write_out,
)

BOUNDS = (-0.002, 0.002)


def _bounds(option: str, text: str) -> Callable[[Command], Command]:
    help_text = f"Least and greatest coefficient of the {text}'s tool, 1/mm."
    return click.option(
        option, type=(float, float), default=BOUNDS, show_default=True, metavar="A A", help=help_text
    )


@click.command()
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@error_sizes("Error")
@click.option(
    "--contact-ratio",
    type=float,
    default=1.6,
    show_default=True,
    metavar="RATIO",
    help="Contact ratio (Eq. 16) to be reached.",
)
@click.option(
    "--off-centre",
    type=float,
    default=1.0,
    show_default=True,
    metavar="MM",
    help="How far the middle of the path may lie from mid-face.",
)
@click.option(
    "--transmission-error",
    type=float,
    metavar="ARCSEC",
    help="Greatest transmission error of the path, peak to peak. Default: any.",
)
@_bounds("--pinion-bounds", "pinion")
@_bounds("--gear-bounds", "gear")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, mm and rad.")
@click.option("--csv", "as_csv", is_flag=True, help="Print CSV, a row each for found and given, mm and rad.")
def optimise(
    design: str,
    flank: str,
    offset: float,
    shaft_angle_deg: float,
    pinion_axial: float,
    gear_axial: float,
    contact_ratio: float,
    off_centre: float,
    transmission_error: float | None,
    pinion_bounds: tuple[float, float],
    gear_bounds: tuple[float, float],
    as_json: bool,
    as_csv: bool,
) -> None:
    """Find the parabola coefficients with which errors shift the path of contact least.

    The path keeps a contact ratio, stays centred on the face, and the flanks are not hollow against
    each other. Give at least one error; some seconds. Exit status 2 if nothing meets the aim.
    """
    require_one_format(as_json, as_csv)
    require_sizes("errors that shift the path", (offset, shaft_angle_deg, pinion_axial, gear_axial))
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its products are too small to be shared out
    given = load_design(design)
    from ..analysis.optimise import Aim, optimise_parabola
    from ..design.model import Errors
    from ..report import optimise as report

    errors = Errors(offset, math.radians(shaft_angle_deg), pinion_axial, gear_axial)
    swing = math.inf if transmission_error is None else math.radians(transmission_error / 3600.0)
    aim = Aim(errors, contact_ratio, off_centre, swing, pinion_bounds, gear_bounds)
    try:
        found = optimise_parabola(given, aim, flank)
    except ValueError as error:
        raise Refusal([str(error)]) from None
    if as_csv:
        write_out(report.optimum_csv(given, found))
        return
    shown = report.optimum_json if as_json else report.optimum_table
    write_out(shown(click.format_filename(design), given, aim, flank, found))
