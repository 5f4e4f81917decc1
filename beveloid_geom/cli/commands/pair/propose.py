"""The command `beveloid-geom propose`."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ...options import SIDES, Refusal, block, load_design, option, option_name
from ...results import named, show

if TYPE_CHECKING:
    from ....design.field_limits import Fault
    from ....proposal.request import Request

TWO = (float, float)
MODULE = "Normal module of both; needed unless --gear has it."
FACE = "Face widths of pinion and gear.  [default: 10 modules]"
OFFSET = "Shortest distance of the axes; 0: they intersect. Left out, it follows from cones or least cones."
BACKLASH = "Normal backlash.  [default: 0.04 modules]"
CONES = "Cone angles of pinion and gear, given."
HELIX = "Helix angle of the pinion, right hand positive; that of the gear follows."
CROSSING = "Angle at which the generators of the drive flanks cross, with --helix-deg; 0 is line contact."
GEAR = "Design whose gear is given, with its tool; the pinion is found."
SHIFTS = "Profile shifts of pinion and gear. Left out, some of use are tried."
OUT = "Write a proposal as a design file, whole or not at all."
PATH = click.Path(path_type=Path)
OPTIONS = block(
    option("--module", float, None, MODULE, "MM"),
    click.option("--teeth", type=(int, int), required=True, metavar="N1 N2", help="Of pinion and gear."),
    option("--shaft-angle-deg", float, None, "Angle of the axes, 0: they are parallel; needed.", "DEG"),
    option("--offset", float, None, OFFSET, "MM"),
    option("--backlash", float, None, BACKLASH, "MM"),
    option("--flank", SIDES, "right", "Drive flanks; the others coast."),
    option("--cones-deg", TWO, None, CONES, "G1 G2"),
    option("--helix-deg", float, None, HELIX, "DEG"),
    option("--crossing-deg", float, None, CROSSING, "DEG"),
    click.option("--least-cones", is_flag=True, help="The least cones that do."),
    option("--gear", str, None, GEAR, "DESIGN"),
    option("--shifts", TWO, None, SHIFTS, "X1 X2"),
    option("--face-widths", TWO, None, FACE, "B1 B2"),
    option("--pressure-angle-deg", float, 20.0, "Normal pressure angle of both tools.", "DEG"),
    option("--cone-limits-deg", TWO, (-15.0, 15.0), "Least and greatest cone angle found.", "LOW HIGH"),
    option("--helix-limits-deg", TWO, (-45.0, 45.0), "The same of helix angles.", "LOW HIGH"),
    option("--shift-limits", TWO, (-0.5, 0.8), "The same of profile shifts.", "LOW HIGH"),
    option("--count", click.IntRange(1, 5), 3, "Proposals at the most."),
    option("--pick", click.IntRange(1, 5), 1, "Which of them --out writes."),
    click.option("--out", type=PATH, metavar="FILE", help=OUT),
    click.option("--json", "as_json", is_flag=True, help="Print JSON, with the design files; mm and rad."),
    click.option("--csv", "as_csv", is_flag=True, help="Print CSV, one design a row, mm and rad."),
    click.pass_context,
)


def propose(
    context: click.Context,
    /,
    count: int,
    pick: int,
    out: Path | None,
    as_json: bool,
    as_csv: bool,
    **given: Any,
) -> None:
    """Find pairs that close for teeth, module and layout, ready for tca without warning, the best first.

    One of --cones-deg, --crossing-deg with --helix-deg, --least-cones and --gear says what of the members
    is given; where axes intersect --helix-deg alone does. What else is free is found: cones, helix angles,
    profile shifts within their limits, and the offset if it is left out. Where no pair is found a line says
    why, and the nearest request for which there is one; exit status 2.
    """
    if as_json and as_csv:
        raise click.UsageError("--json and --csv exclude each other: give one of them")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its products are too small to be shared out
    source = given.pop("gear") or ""
    request = request_of(source, **given)
    from ....design.field_limits import DesignError
    from ....proposal.propose import Refused, propose as propose_on
    from ....proposal.words import refusal
    from ....report.closing import ProposalReport

    try:
        report = ProposalReport(request, propose_on(request, count), source)
    except DesignError as error:
        raise refused(error.parts) from None
    except Refused as error:
        raise Refusal([refusal(request, error.reason, error.nearest)]) from None
    if out is not None:
        write(report.text_of, pick, len(report.proposals), out)
    show(context, report, as_json, as_csv)


def request_of(source: str, **given: Any) -> Request:
    """Make the request of the options, angles in rad. Raises Refusal for what is missing."""
    from ....proposal.request import BACKLASH, FACE, Bounds, Request, teeth_faults

    if faults := tuple(teeth_faults(given["teeth"])):
        raise refused(faults)
    gear = load_design(source).gear if source else None
    module = given["module"] if gear is None else float(gear.tool.normal_module)
    needed = {"--module": module, "--shaft-angle-deg": given["shaft_angle_deg"]}
    if missing := [name for name, value in needed.items() if value is None]:
        raise Refusal(f"{name} is missing" for name in missing)
    if gear is not None and given["module"] not in (None, module):
        raise Refusal([f"--module must be {module:g} of the gear, as --gear has: leave it out"])

    def angles(key: str) -> Any:
        """Give an angle, or two, in rad."""
        value = given[key]
        return tuple(map(math.radians, value)) if isinstance(value, tuple) else value and math.radians(value)

    faces = given["face_widths"] or (FACE * module,) * 2
    return Request(
        module=module,
        teeth=given["teeth"],
        face_widths=faces if gear is None else (faces[0], float(gear.face_width)),
        shaft_angle=angles("shaft_angle_deg"),
        backlash=BACKLASH * module if given["backlash"] is None else given["backlash"],
        offset=given["offset"],
        flank=given["flank"],
        cone_angles=angles("cones_deg"),
        helix_angle=angles("helix_deg"),
        crossing=angles("crossing_deg"),
        least_cones=given["least_cones"],
        shifts=given["shifts"],
        gear=gear,
        pressure_angle=angles("pressure_angle_deg")
        if gear is None
        else float(gear.tool.normal_pressure_angle),
        cone_limits=Bounds(*angles("cone_limits_deg")),
        helix_limits=Bounds(*angles("helix_limits_deg")),
        shift_limits=Bounds(*given["shift_limits"]),
    )


def refused(faults: Iterable[Fault]) -> Refusal:
    """Make the refusal of faults, by the options' names."""
    named_faults = ((fault.key and option_name(fault.key), fault.text) for fault in faults)
    return Refusal(" ".join(part for part in parts if part) for parts in named_faults)


def write(text_of: Callable[[int], str], pick: int, count: int, out: Path) -> None:
    """Write a proposal. Raises Refusal where there is none of that number, or the file cannot be written."""
    from ....support.whole_file import whole_file

    if pick > count:
        raise Refusal([f"--pick must be between 1 and {count}, as many are proposed, got {pick}"])
    try:
        with whole_file(out) as beside:
            beside.write_text(text_of(pick), encoding="utf-8")
    except OSError as error:
        reason = error.strerror or error
        raise Refusal(
            [f"cannot write {click.format_filename(out)} ({reason}): choose another --out"]
        ) from None


command = named(propose, OPTIONS(propose))
