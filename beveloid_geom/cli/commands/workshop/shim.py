"""The command `beveloid-geom shim`."""

from __future__ import annotations

import math

import click

from ... import results
from ...options import NumberRange, Refusal, changed_design, flank_option, option, parabola_options

OFFSET = "Offset of the housing as measured.  [default: the design's, with its error]"
SHAFT_ANGLE = "Shaft angle of the housing as measured.  [default: the design's, with its error]"
AT = "Where on the pinion's face the middle of the path is wanted, from the toe; else least moves."


@results.result_command(
    option("--offset", float, None, OFFSET, "MM"),
    option("--shaft-angle-deg", float, None, SHAFT_ANGLE, "DEG"),
    click.option(
        "--backlash",
        type=NumberRange(0.0, 100.0),
        required=True,
        metavar="MM",
        help="Normal backlash wanted, the least over a mesh cycle.",
    ),
    option("--at", NumberRange(0.0, 100.0, min_open=True, max_open=True), None, AT, "PERCENT"),
    flank_option,
    parabola_options,
    csv="one member a row",
)
def shim(
    name: str,
    design: results.Design,
    offset: float | None,
    shaft_angle_deg: float | None,
    backlash: float,
    at: float | None,
    flank: str,
) -> results.Result:
    """Find the axial positions of pinion and gear that give a backlash in a housing as measured.

    With --at the middle of the path is put there, too; else both are moved as little as can be. Met to 1e-9
    mm in the pair solved anew, or why not. Some seconds. Exit status 1 if there are none, or more than a
    face width away.
    """
    from ....findings.path import first_contact_fault
    from ....report.workshop.shim import shim_report

    measured = _measured(design, offset, shaft_angle_deg)
    if fault := first_contact_fault(measured):
        raise click.ClickException(f"no first contact: {fault}")  # status 1
    with results.refused_values():
        return shim_report(name, measured, backlash, None if at is None else at / 100.0, flank)


def _measured(design: results.Design, offset: float | None, shaft_angle_deg: float | None) -> results.Design:
    """Give the design in a housing of this offset (mm) and shaft angle. Raises Refusal."""
    own = {"offset": float(design.pair.offset), "shaft_angle_deg": math.degrees(design.pair.shaft_angle)}
    given = {"offset": offset, "shaft_angle_deg": shaft_angle_deg}
    changes = {
        name.replace("_deg", "") + ("_error_deg" if "_deg" in name else "_error"): value - own[name]
        for name, value in given.items()
        if value is not None
    }
    try:
        return changed_design(design, changes)
    except Refusal as refusal:
        raise Refusal(f"as measured less the design's: {fault}" for fault in refusal.faults) from None
