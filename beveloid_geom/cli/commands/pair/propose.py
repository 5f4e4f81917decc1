"""The command `beveloid-geom propose`."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...options import (
    SIDES,
    Refusal,
    block,
    given_options,
    load_design,
    option,
    option_name,
    refuse_without,
)
from ...results import check_out, named, out_options, show, write_design

if TYPE_CHECKING:
    from ....design.field_limits import Fault
    from ....design.member import Member
    from ....proposal.request import Request

propose_options = block(
    option("--module", float, None, "Normal module of both members; required without --gear.", "MM"),
    click.option(
        "--teeth", type=(int, int), required=True, metavar="N1 N2", help="Teeth of pinion and gear."
    ),
    option("--shaft-angle-deg", float, None, "Shaft angle, 0 for parallel axes; required.", "DEG"),
    option(
        "--offset",
        float,
        None,
        "Shortest distance of the axes; 0 for intersecting axes. If omitted, it is computed.",
        "MM",
    ),
    option("--backlash", float, None, "Normal backlash.  [default: 0.04 modules]", "MM"),
    option("--flank", SIDES, "right", "Drive flanks; the other flanks coast."),
    option("--cones-deg", (float, float), None, "Cone angles of pinion and gear.", "G1 G2"),
    option(
        "--helix-deg",
        float,
        None,
        "Helix angle of the pinion, right hand positive; the helix angle of the gear is computed.",
        "DEG",
    ),
    option(
        "--crossing-deg",
        float,
        None,
        "Angle between the straight generators of the drive flanks, with --helix-deg; 0 is line contact.",
        "DEG",
    ),
    click.option(
        "--least-cones",
        is_flag=True,
        help="Minimise the larger of the two cone angles. This is the default without --cones-deg,"
        " --crossing-deg and --gear, but not for --helix-deg with --offset 0.",
    ),
    option("--gear", str, None, "Design whose gear and tool are given; the pinion is computed.", "DESIGN"),
    option(
        "--shifts",
        (float, float),
        None,
        "Profile shifts of pinion and gear. If omitted, common values are tried.",
        "X1 X2",
    ),
    option(
        "--face-widths",
        (float, float),
        None,
        "Face widths of pinion and gear.  [default: 10 modules]",
        "B1 B2",
    ),
    option(
        "--pressure-angle-deg", float, None, "Normal pressure angle of both tools.  [default: 20.0]", "DEG"
    ),
    option(
        "--cone-limits-deg", (float, float), (-15.0, 15.0), "Limits of the computed cone angles.", "LOW HIGH"
    ),
    option(
        "--helix-limits-deg",
        (float, float),
        (-45.0, 45.0),
        "Limits of the computed helix angles.",
        "LOW HIGH",
    ),
    option(
        "--shift-limits", (float, float), (-0.5, 0.8), "Limits of the computed profile shifts.", "LOW HIGH"
    ),
    option("--count", click.IntRange(1, 5), 3, "Largest number of proposals."),
    option("--pick", click.IntRange(1, 5), 1, "Number of the proposal that --out writes."),
    out_options,
    click.option("--json", "as_json", is_flag=True, help="Print JSON, with the design files; mm and rad."),
    click.option("--csv", "as_csv", is_flag=True, help="Print CSV, one design per row, mm and rad."),
    click.pass_context,
)


def propose_command(
    context: click.Context,
    /,
    count: int,
    pick: int,
    out: Path | None,
    overwrite: bool,
    as_json: bool,
    as_csv: bool,
    **given: Any,
) -> None:
    """Propose pairs for teeth, module and layout, the best first; each has contact and no warning of `check`.

    Give one of --cones-deg, --crossing-deg with --helix-deg, --least-cones and --gear; for intersecting axes,
    --helix-deg alone is sufficient. Without any of them the cone angles are minimised. All other quantities
    are computed: cones, helix angles and profile shifts within their limits, and the offset if it is omitted.
    They are rounded to the fewest decimals that keep layout and backlash within tolerances. If no pair is
    found, a message gives the reason and the nearest request with a solution; exit status 2."""
    if as_json and as_csv:
        raise click.UsageError("--json and --csv exclude each other: give one of them")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads do not pay for small products
    source = given.pop("gear") or ""
    request = request_of(source, **given)
    from ....design.field_limits import DesignError
    from ....proposal.command_line import refusal
    from ....proposal.propose import Refused
    from ....report.check import proposal_report

    check_out(out, overwrite)
    if out is None:
        refuse_without("--out", ("pick",))
    try:
        report = proposal_report(request, count, source)
    except DesignError as error:
        raise refusal_of(error.parts) from None
    except Refused as error:
        raise Refusal([refusal(request, error.reason, error.nearest)]) from None
    if out is not None:
        if pick > (count := len(report.proposals)):
            raise Refusal([f"--pick must be between 1 and {count}, the number of proposals, got {pick}"])
        write_design(report.text_of(pick), out)
        summary = f"proposal {pick} of {count}, {report.words_of(pick)}"
        click.echo(f"{click.format_filename(out)}: {summary}", err=as_json or as_csv)
    show(context, report, as_json, as_csv)


def request_of(source: str, **given: Any) -> Request:
    """Return the request of the options, angles in rad. Raises Refusal for missing options."""
    from ....proposal.request import DEFAULT_BACKLASH_MODULES, Bounds, Request, teeth_faults

    if faults := tuple(teeth_faults(given["teeth"])):
        raise refusal_of(faults)
    gear = load_design(source).gear if source else None
    module = given["module"] if gear is None else float(gear.tool.normal_module)
    needed = {"--module": module, "--shaft-angle-deg": given["shaft_angle_deg"]}
    if missing := [name for name, value in needed.items() if value is None]:
        cures = {
            "--module": "give it in mm, or give --gear",
            "--shaft-angle-deg": "give it in deg, 0 for parallel axes",
        }
        raise Refusal(f"{name} is missing: {cures[name]}" for name in missing)
    _refuse_contradictions(given, gear)
    pressure_angle = given["pressure_angle_deg"]

    def angles(key: str) -> Any:
        """Return one or two angles in rad."""
        value = given[key]
        return tuple(map(math.radians, value)) if isinstance(value, tuple) else value and math.radians(value)

    chosen = gear is not None or not (given["cones_deg"] is None and given["crossing_deg"] is None)
    helix_alone = given["offset"] == 0.0 and given["helix_deg"] is not None
    faces = given["face_widths"] or (10.0 * module,) * 2
    return Request(
        module=module,
        teeth=given["teeth"],
        face_widths=faces if gear is None else (faces[0], float(gear.face_width)),
        shaft_angle=angles("shaft_angle_deg"),
        backlash=DEFAULT_BACKLASH_MODULES * module if given["backlash"] is None else given["backlash"],
        offset=given["offset"],
        flank=given["flank"],
        cone_angles=angles("cones_deg"),
        helix_angle=angles("helix_deg"),
        crossing=angles("crossing_deg"),
        least_cones=given["least_cones"] or not (chosen or helix_alone),
        shifts=given["shifts"],
        gear=gear,
        pressure_angle=math.radians(20.0 if pressure_angle is None else pressure_angle)
        if gear is None
        else float(gear.tool.normal_pressure_angle),
        cone_limits=Bounds(*angles("cone_limits_deg")),
        helix_limits=Bounds(*angles("helix_limits_deg")),
        shift_limits=Bounds(*given["shift_limits"]),
    )


def _refuse_contradictions(given: dict[str, Any], gear: Member | None) -> None:
    """Raise Refusal for limits of values that are given, and for data of the tool and the gear that differ
    from those of `gear`."""
    for limits, fixed in (("cone_limits_deg", "cones_deg"), ("shift_limits", "shifts")):
        if given[fixed] is not None and given_options((limits,)):
            text = f"{option_name(limits)} has no effect with {option_name(fixed)}"
            raise Refusal([f"{text}: omit one of them"])
    if gear is None:
        return
    width = None if given["face_widths"] is None else given["face_widths"][1]
    tool_angle = math.degrees(float(gear.tool.normal_pressure_angle))
    for name, quantity, value, known in (
        ("--module", "module", given["module"], float(gear.tool.normal_module)),
        ("--pressure-angle-deg", "pressure angle", given["pressure_angle_deg"], tool_angle),
        ("second value of --face-widths", "face width", width, float(gear.face_width)),
    ):
        # The echoed command line has six digits.
        if value is not None and not math.isclose(value, known, rel_tol=1e-5):
            limit = f"must be {known:g}, the {quantity} of --gear, got {value:g}"
            raise Refusal([f"{name} {limit}: omit the option, or give this value"])


def refusal_of(faults: Iterable[Fault]) -> Refusal:
    """Return the Refusal for faults, with the names of the options."""
    named_faults = ((fault.key and option_name(fault.key), fault.text) for fault in faults)
    return Refusal(" ".join(part for part in parts if part) for parts in named_faults)


command = named(propose_command, propose_options(propose_command))
