"""The command `beveloid-geom modify`."""

from __future__ import annotations

import math
from pathlib import Path

import click

from ... import results
from ...options import ABOVE_ZERO, flank_option, option, override_options


@results.result_command(
    click.option(
        "--transmission-error-arcsec",
        type=ABOVE_ZERO,
        required=True,
        metavar="ARCSEC",
        help="Required transmission error of all teeth, peak to peak, as `operation` prints it.",
    ),
    click.option(
        "--length",
        type=ABOVE_ZERO,
        required=True,
        metavar="MM",
        help="Required length of the contact pattern along the face of the modified member.",
    ),
    option("--member", click.Choice(["pinion", "gear"]), "pinion", "Member that is modified."),
    option("--separation", ABOVE_ZERO, 0.00635, "Thickness of the marking compound.", "MM"),
    flank_option,
    override_options,
    results.out_options,
    csv="one row",
)
def modify(
    name: str,
    design: results.Design,
    transmission_error_arcsec: float,
    length: float,
    member: str,
    separation: float,
    flank: str,
    out: Path | None,
    overwrite: bool,
) -> results.Result:
    """Compute the helix and profile crowning that give a transmission error and a length of the contact
    pattern.

    The result replaces both crownings of the driving flank of the member. Its other amounts of modification
    and the parabolas are kept. Transmission error and pattern are computed as by `operation` and `pattern`.
    The calculation takes some seconds. The exit status is 2 if no crownings that remove material give both
    values."""
    results.check_out(out, overwrite)
    results.check_measured(design, [member], flank, out)
    from ....analysis.modification.crowning import fit_crowning
    from ....design.text import design_text
    from ....report.optimisation.crowning import CrowningReport

    error = math.radians(transmission_error_arcsec / 3600.0)
    with results.refused_values():
        crowning = fit_crowning(design, error, length, flank, member=member, separation=separation)
    if out is not None:
        remark = f"{name} with {1e3 * separation:g} um thick marking compound on {length:g} mm, and"
        remark += f" {transmission_error_arcsec:g} arcsec of transmission error, {flank} flanks."
        results.write_design(design_text(crowning.design, remark), out)
    return CrowningReport(name, design, crowning)
