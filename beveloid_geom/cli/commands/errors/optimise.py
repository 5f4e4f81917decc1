"""The command `beveloid-geom optimise`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ... import results
from ...options import (
    ABOVE_ZERO,
    MEMBERS,
    Number,
    NumberRange,
    Refusal,
    bounds_options,
    flank_option,
    given_options,
    option,
    renamed,
)
from ...tolerance_options import errors_of, sizes_of, tolerance_options

if TYPE_CHECKING:
    from ....pair.named_inputs import Bounds

UPPER_LIMIT = NumberRange(0.0, min_open=True)  # infinity is no limit


@results.result_command(
    flank_option,
    tolerance_options,
    option(
        "--least",
        click.Choice(["shift", "transmission-error"]),
        "shift",
        "Minimised quantity under errors; transmission-error (of all teeth) requires --no-edges.",
    ),
    option("--contact-ratio", ABOVE_ZERO, 1.6, "Minimum contact ratio of one tooth pair (Eq. 16).", "RATIO"),
    option(
        "--off-centre", ABOVE_ZERO, 1.0, "Largest distance of the middle of the path from mid-face.", "MM"
    ),
    option(
        "--transmission-error-arcsec",
        UPPER_LIMIT,
        math.inf,
        "Upper limit of the transmission error of the path, peak to peak. Default: no limit.",
        "ARCSEC",
    ),
    renamed("--transmission-error", "--transmission-error-arcsec"),
    option(
        "--shift",
        UPPER_LIMIT,
        math.inf,
        "Upper limit of the shift of the path under the errors. Default: no limit.",
        "MM",
    ),
    bounds_options("Lower and upper limit of the coefficient of the {}, 1/mm.", (-0.002, 0.002)),
    click.option(
        "--no-edges",
        is_flag=True,
        help="Require no edge contact in the mesh cycle, without errors and under each single error.",
    ),
    click.option(
        "--vary",
        type=(str, Number(), Number()),
        multiple=True,
        metavar="AMOUNT LOW HIGH",
        help="Optimise this amount of modification between limits in um, such as --vary pinion.helix_crowning"
        " 0 20, in place of the parabola coefficients. A relief needs its length in the design. Can be"
        " repeated.",
    ),
    results.out_options,
    csv="one row for the optimum and one for the design",
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
    vary: tuple[tuple[str, float, float], ...],
    out: Path | None,
    overwrite: bool,
    **tolerances: float | None,
) -> results.Result:
    """Compute the parabola coefficients with the smallest shift of the path under errors, or with the
    smallest transmission error of all teeth; with --vary, amounts of modification.

    Constraints are the contact ratio, the position of the middle of the path on the face, and a positive
    relative curvature of the flanks; with --no-edges, no edge contact. The errors are as large as their
    tolerances (if none is given, the usual tolerances of the command `tolerance`), each alone and
    in both directions. The shift is the movement of the middle of the path, perpendicular to the path, as
    root of the sum of squares over the errors (as in `map`). --vary changes only the driving flanks, and
    keeps the parabolas and all other amounts of the design. If the optimum is on a bound, this is reported.
    The calculation takes some seconds. The exit status is 2 if no values meet the constraints."""
    sizes = sizes_of(tolerances, design)
    if least == "transmission-error" and not no_edges:
        raise Refusal([f"--least {least} requires teeth without edge contact: add --no-edges"])
    results.check_out(out, overwrite)
    from ....analysis.modification.amounts import optimise_amounts
    from ....analysis.optimise import Aim, optimise_parabola
    from ....design.text import design_text
    from ....report.optimisation.optimum import amounts_report, parabola_report

    peak_to_peak = math.radians(transmission_error_arcsec / 3600.0)
    aim = Aim(
        errors=errors_of(sizes),
        contact_ratio=contact_ratio,
        off_centre=off_centre,
        peak_to_peak=peak_to_peak,
        pinion_parabola=pinion_bounds,
        gear_parabola=gear_bounds,
        edges=not no_edges,
        shift=shift,
        least="transmission_error" if least == "transmission-error" else "shift",
    )
    # Lead is another word for helix.
    keys = {each: each.replace(".lead_", ".helix_").removesuffix("_um") + "_um" for each, *_ in vary}
    amounts = {keys[each]: (low, high) for each, low, high in vary}
    members = {name.partition(".")[0] for name in amounts} & {"pinion", "gear"}
    results.check_measured(design, sorted(members), flank, out)
    if len(amounts) < len(vary):
        raise Refusal(["--vary names an amount twice: remove one of them"])
    for given in given_options(("pinion_bounds", "gear_bounds")) if vary else ():
        cure = "omit it, --vary contains the limits of the amounts"
        raise Refusal([f"{given} is for parabola coefficients: {cure}"])
    with results.refused_values(_options_of(keys)):
        if amounts:
            result = optimise_amounts(design, aim, amounts, flank)
            report = amounts_report(name, design, aim, flank, result, amounts)
        else:
            report = parabola_report(name, design, aim, flank, optimise_parabola(design, aim, flank))
    if out is not None:
        results.write_design(design_text(report.optimum.design, f"Optimum of {name}, {flank} flanks."), out)
    return report


def _options_of(keys: Mapping[str, str]) -> dict[str, str]:
    """Return the options by the arguments that messages of the optimisation name: --vary by the `keys` of
    the amounts, and the bounds of the parabola coefficients."""
    options = {f"{what}{key}": f"--vary {name}" for name, key in keys.items() for what in ("", "bounds of ")}
    for member in MEMBERS:
        names = f"{member}_parabola of the aim", f"bounds of parabola_{member}"
        options |= dict.fromkeys(names, f"--{member}-bounds")
    return options
