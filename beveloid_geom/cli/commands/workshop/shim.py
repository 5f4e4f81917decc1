"""The command `beveloid-geom shim`."""

from __future__ import annotations

import math

import click

from ... import results
from ...options import NumberRange, Refusal, changed_design, flank_option, no_result, option, tooth_options


@results.result_command(
    option(
        "--offset",
        float,
        None,
        "Measured offset of the housing.  [default: offset of the design, with its error]",
        "MM",
    ),
    option(
        "--shaft-angle-deg",
        float,
        None,
        "Measured shaft angle of the housing.  [default: shaft angle of the design, with its error]",
        "DEG",
    ),
    click.option(
        "--backlash",
        type=NumberRange(0.0, 100.0),
        required=True,
        metavar="MM",
        help="Required normal backlash: its smallest value over a mesh cycle.",
    ),
    option(
        "--at",
        NumberRange(0.0, 100.0, min_open=True, max_open=True),
        None,
        "Position of the middle of the path on the pinion face, from the end at -z. If omitted, the"
        " displacements are as small as possible.",
        "PERCENT",
    ),
    flank_option,
    tooth_options,
    csv="one member per row",
)
def shim_command(
    name: str,
    design: results.Design,
    offset: float | None,
    shaft_angle_deg: float | None,
    backlash: float,
    at: float | None,
    flank: str,
) -> results.Result:
    """Compute the axial positions of pinion and gear for a given backlash in a measured housing.

    With --at, the middle of the path is also moved to this position; otherwise the displacements are as small
    as possible. The backlash is reached to 1e-9 mm; this is checked by solving the displaced pair. The
    calculation takes some seconds. The exit status is 1 if axial positions do not change the backlash, if no
    position that was tried has a path, or if the positions are more than a face width away; 4 if the search
    found none, because there are none or because a calculation failed."""
    from ....findings.path import first_contact_fault
    from ....report.workshop.shim import shim_report

    measured = _measured(design, offset, shaft_angle_deg)
    if fault := first_contact_fault(measured):
        raise no_result(fault)
    with results.refused_values():
        return shim_report(name, measured, backlash, None if at is None else at / 100.0, flank)


def _measured(design: results.Design, offset: float | None, shaft_angle_deg: float | None) -> results.Design:
    """Return the design in a housing with this offset (mm) and shaft angle. Raises Refusal."""
    nominal = {"offset": float(design.pair.offset), "shaft_angle_deg": math.degrees(design.pair.shaft_angle)}
    given = {"offset": offset, "shaft_angle_deg": shaft_angle_deg}
    errors = {"offset": "offset_error", "shaft_angle_deg": "shaft_angle_error_deg"}
    changes = {errors[name]: value - nominal[name] for name, value in given.items() if value is not None}
    try:
        return changed_design(design, changes)
    except Refusal as refusal:
        # A measured value is the design value plus an assembly error. If the error exceeds its limits, the
        # message names the option of this command instead of the error, and has another cure.
        faults = (fault.partition(": ")[0] for fault in refusal.faults)
        words = {
            f"--{error}".replace("_", "-"): f"--{name}".replace("_", "-") for name, error in errors.items()
        }
        raise Refusal(
            f"{words[option]} minus that of the design {limit}: check the number, or change the design"
            for option, _, limit in (fault.partition(" ") for fault in faults)
        ) from None
