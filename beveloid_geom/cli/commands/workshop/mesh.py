"""Command `beveloid-geom mesh`: write a part of a pair as a file for other programs."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from ....export import (
    CAD_FORMATS,
    CONTACT_FORMATS,
    FIELD_FORMATS,
    SCENE_FORMATS,
    SURFACE_FORMATS,
    VOLUME_FORMATS,
    suffixes_by_purpose,
)
from ....shapes import MODULE_PER_TOLERANCE
from ...mesh_options import PARTS, mesh_options
from ...mesh_parts import FLANKS, GEARS, TEETH, WRITERS, MeshRequest, frames_text
from ...options import (
    MEMBERS,
    MODIFIED,
    OVERRIDES,
    PARABOLAS,
    Refusal,
    changed_design,
    load_design,
    no_result,
    note_equal_teeth,
    option_name,
    write_out,
)
from ...results import named, refused_values, unfinished_file

if TYPE_CHECKING:
    from ....design.member import Member
    from ....design.model import Design


@dataclass(frozen=True)
class PartKind:
    """Kind of geometry.

    Attributes
    ----------
    formats : dict
        Formats by suffix.
    parts : tuple of str
        Parts that can be written.
    description : str
        Text for messages.
    module_per_tolerance : float or None
        Module divided by the default tolerance, None if no tolerance is needed.
    """

    formats: dict[str, Any]
    parts: tuple[str, ...]
    description: str
    module_per_tolerance: float | None = MODULE_PER_TOLERANCE


KINDS = {
    "volume": PartKind(VOLUME_FORMATS, TEETH, f"hexahedra of {' or '.join(TEETH)}", 120.0),
    "contact": PartKind(CONTACT_FORMATS, ("pair",), "the pair in contact", None),
    "surface": PartKind(SURFACE_FORMATS, PARTS, "surface"),
    "solid": PartKind(
        CAD_FORMATS, (*GEARS, *TEETH, "pair"), f"solid of {', '.join((*GEARS, *TEETH, 'pair'))}"
    ),
    "scene": PartKind(SCENE_FORMATS, ("pair",), "the pair for viewers, with paths and patterns", 200.0),
}
"""Kinds in the order in which they are tried: a tooth as .vtu is hexahedra."""


def kind_of(part: str, suffix: str, teeth: int) -> str:
    """Return the key of KINDS for a part in a format, of a gear with a number of teeth. Raises Refusal."""
    for name, kind in KINDS.items():
        if part in kind.parts and suffix in kind.formats:
            return name
    known = any(suffix in kind.formats for kind in KINDS.values())
    shown = suffix or "a name without a suffix"
    kinds = "; ".join(f"{', '.join(kind.formats)} ({kind.description})" for kind in KINDS.values())
    fault = f"a {part} cannot be written as {suffix}" if known else f"{shown} is not a known format"
    if part in GEARS and suffix in VOLUME_FORMATS:
        cure = f"for hexahedra of all teeth, give --part {part}-tooth --teeth {teeth}"
        raise Refusal([f"--out: {fault}: {cure}"])
    raise Refusal([f"--out: {fault}: give one of {kinds}"])


def refuse_unused(context: click.Context, request: MeshRequest, frames: bool) -> None:
    """Raise Refusal for each given option that does not change the output."""
    teeth, flanks, solids = " and ".join(TEETH), " and ".join(FLANKS), (*GEARS, *TEETH)
    in_contact, part, suffix = request.needs_contact, request.part, request.suffix
    contact = request.kind == "contact"
    mounted = "the pair, a part --placed, a flank with --field, and a tooth as .inp"
    uses = {
        **{name: (in_contact, mounted) for name, *_ in OVERRIDES},
        **{
            name: (in_contact or request.number == number, f"the {member}, {mounted}")
            for number, member in enumerate(("pinion", "gear"))
            for name, *_ in PARABOLAS + MODIFIED
            if member in name
        },
        "flank": (in_contact or part in FLANKS, f"flanks, {mounted}"),
        "placed": (part != "pair", ", ".join((*GEARS, *TEETH, *FLANKS))),
        "teeth": (part in TEETH or contact, f"{teeth}, and the pair as .inp"),
        "bore_radius": (part in (*solids, "pair"), f"{', '.join(solids)} and the pair"),
        **dict.fromkeys(("pinion_bore_radius", "gear_bore_radius"), (part == "pair", "the pair")),
        **dict.fromkeys(("torque", "across", "rolls"), (contact, "the pair as .inp")),
        "roll_deg": (part == "pair" or request.placed or frames, "the pair, a part --placed and --frames"),
        "tolerance": (request.kind != "solid", "surfaces and hexahedra"),
        "element": (request.kind == "volume", f"{teeth} as {', '.join(VOLUME_FORMATS)}"),
        "load": (suffix == ".inp" and not contact, f"{teeth} as .inp"),
        "field": (part in FLANKS and suffix in FIELD_FORMATS, f"{flanks} as {', '.join(FIELD_FORMATS)}"),
    }
    faults = [
        f"{option_name(name)} is for {only}, not for {part} as {suffix}: omit it"
        for name, (used, only) in uses.items()
        if not used and context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    ]
    if faults:
        raise Refusal(faults)


def check_numbers(request: MeshRequest, bores: dict[str, float | None]) -> None:
    """Raise Refusal for invalid lengths, forces and numbers of teeth; `bores` are the bore options."""
    given = (
        ("--tolerance", request.tolerance, "mm", "usual values are 0.001 to 0.1"),
        *(
            (option_name(name), value, "mm", "omit it for 0.45 of the root radius")
            for name, value in bores.items()
        ),
        ("--load", request.load, "N", "give its magnitude, it pushes on the flank"),
        ("--across", request.across, "", "use 4 for pressures, 1 for load sharing"),
        ("--torque", request.torque, "N m", "give its magnitude, --flank selects the flanks in contact"),
    )
    faults = [
        f"{option} must be a finite number above 0{unit and ' '}{unit}, got {value:g}: {cure}"
        for option, value, unit, cure in given
        if value is not None and not (math.isfinite(value) and value > 0.0)
    ]
    if request.roll_deg is not None and not math.isfinite(request.roll_deg):
        cure = "omit it for the middle of the path"
        faults.append(f"--roll-deg must be a finite angle in deg, got {request.roll_deg:g}: {cure}")
    if request.rolls is not None and request.roll_deg is not None:
        faults.append("--roll-deg and --rolls exclude each other: give one of them")
    if request.teeth > request.member.teeth:
        most = int(request.member.teeth)
        faults.append(
            f"--teeth must be between 1 and {most}, got {request.teeth}: {most} is the complete gear"
        )
    if faults:
        raise Refusal(faults)
    if request.part == "pair":
        _check_bores(request, bores)


def _check_bores(request: MeshRequest, bores: dict[str, float | None]) -> None:
    """Raise Refusal for a bore of the pair outside its limits, with the name of its option."""
    from ....shapes.tooth_body import bore_of
    from ....support.argument import ArgumentError

    for member, name, radius in zip(request.design.members, MEMBERS, request.bore_radii, strict=True):
        given = f"{name}_bore_radius" if bores[f"{name}_bore_radius"] is not None else "bore_radius"
        try:
            if radius is not None:
                bore_of(member, radius)
        except ArgumentError as error:
            raise Refusal([f"{option_name(given)} {error.text}"]) from None


@contextmanager
def refused_writing(request: MeshRequest) -> Iterator[None]:
    """Raise Refusal if the file cannot be written, the geometry is invalid or the memory is not sufficient.

    Raises NoResult if the first contact is not known."""
    from ....operation.contact_pattern.motion import UnknownOperationError
    from ....support.argument import ArgumentError

    try:
        with refused_values():
            yield
    except OSError as error:
        # Some libraries only report that writing failed.
        reason = error.strerror or f"{error}, is the disk full?"
        name = click.format_filename(error.filename2 or request.out)  # filename2: the target of a renaming
        raise Refusal([f"cannot write {name} ({reason}): choose another --out"]) from None
    except MemoryError:
        cure = "the pair in contact: use a smaller --across or fewer --teeth"
        if request.kind == "solid":
            cure = f"{request.part} as {request.suffix}: write a smaller part, such as a tooth"
        elif request.tolerance is not None:
            cure = f"--tolerance {request.tolerance:g}: use a larger value"
        raise Refusal([f"not enough memory for {cure}"]) from None
    except ArgumentError as error:
        raise Refusal([f"{option_name(error.argument)} {error.text}"]) from None
    except UnknownOperationError as error:
        missing = "contact" if request.kind == "contact" else "pattern"
        raise no_result(error.reason, f"no {missing}") from None
    except ImportError as error:
        raise Refusal([str(error)]) from None


def mesh(context: click.Context, /, design: str, field: tuple[str, ...], **given: Any) -> None:
    """Write a gear, a tooth, a flank or the pair as a file for other programs.

    {formats}

    Surfaces for ParaView have exact normals and fields. Hexahedra have named sets; a .inp file also has a
    load and supports and is ready to run. Lengths are in mm. Coordinates are in the frame of the gear. The
    pair, and a part with --placed, are in S_f (z along the pinion axis, x along the common perpendicular), at
    the roll in the middle of the path of contact or at --roll-deg.

    In the pair in contact, the gear is held and a torque turns the pinion. `render-figures --loaded` draws
    the results of CalculiX (ccx) over a pitch.
    """
    if not (given["frames"] and given["part"] is None and given["out"] is None):
        require_part_and_out(context)
    changed = changed_design(load_design(design), {name: given.pop(name) for name, *_ in OVERRIDES})
    note_equal_teeth(changed)
    frames = given.pop("frames")
    if frames:
        write_out(frames_text(changed, given["flank"], given["roll_deg"]))
    if given["part"] is not None:
        write_part(context, changed, click.format_filename(design), field, frames, given)


def require_part_and_out(context: click.Context) -> None:
    """Raise MissingParameter if --part or --out is missing."""
    for parameter in context.command.params:
        if parameter.name in ("part", "out") and context.params[parameter.name] is None:
            raise click.MissingParameter(ctx=context, param=parameter)


def write_part(
    context: click.Context,
    changed: Design,
    source: str,
    field: tuple[str, ...],
    frames: bool,
    given: dict[str, Any],
) -> None:
    """Write the part and print a line for each file."""
    # Load on a tooth of module 6 mm. It scales with the square of the module, which keeps stresses the
    # same.
    default_load_n = 1000.0
    part, suffix = given["part"], given["out"].suffix.lower()
    member = changed.members[part.startswith(MEMBERS[1])]
    kind = kind_of(part, suffix, int(member.teeth))
    module = float(member.tool.normal_module)
    load, teeth = default_load_n * (module / 6.0) ** 2, 3 if kind == "contact" else 1
    divisor = KINDS[kind].module_per_tolerance
    defaults = {"tolerance": None if divisor is None else module / divisor, "load": load, "teeth": teeth}
    given |= {name: value for name, value in defaults.items() if given[name] is None}
    bores = {
        name: given.pop(name) for name in ("bore_radius", *(f"{member}_bore_radius" for member in MEMBERS))
    }
    radii = (bores[f"{name}_bore_radius"] for name in MEMBERS)
    pinion_bore, gear_bore = (bores["bore_radius"] if radius is None else radius for radius in radii)
    fields = tuple(dict.fromkeys(field))
    request = MeshRequest(
        source, changed, suffix, kind, fields=fields, bore_radii=(pinion_bore, gear_bore), **given
    )
    refuse_unused(context, request, frames)
    check_numbers(request, bores)
    if part in FLANKS:
        warn_of_undercut(request.member, request.flank)
    if part == "pair" and kind != "contact":  # the pair in contact is not written if it jams
        warn_of_jam(changed)
    write_files(request)


def write_files(request: MeshRequest) -> None:
    """Write the file of each roll. All files take their places together, after the last one is written."""
    from tqdm import tqdm

    each = request.each
    bar = tqdm(total=2 * len(each), disable=None, leave=False, file=sys.stderr)
    with bar, refused_writing(request), ExitStack() as files:
        unfinished, messages = [], []
        for one in each:
            with refused_writing(one):
                unfinished.append(files.enter_context(unfinished_file(one.out)))
        for one, path in zip(each, unfinished, strict=True):
            bar.set_description(request.part)
            with refused_writing(one):
                text = WRITERS[request.kind](one, path, bar)
            messages.append(f"{click.format_filename(one.out)}: {text}\n")
    write_out("".join(messages))


def warn_of_jam(design: Design) -> None:
    """Write a warning on standard error if the pair cannot be assembled."""
    from ....findings.backlash import backlash_report

    if jam := backlash_report(design).jam:
        click.echo(f"Warning: {jam}; it is written as if it could", err=True)


def warn_of_undercut(member: Member, flank: str) -> None:
    """Write a warning on standard error if undercut shortens a flank."""
    from ....gear.undercut import undercut_of, undercut_text

    try:
        undercut = undercut_of(member, flank)
    except ValueError as error:
        click.echo(f"Warning: {error}", err=True)
        return
    if undercut.undercut:
        written = (
            "written as if there were no undercut"
            if math.isinf(undercut.lost.max())
            else "written down to the fillet"
        )
        click.echo(
            f"Warning: the {flank} flank is undercut {undercut_text(undercut)}; it is {written}", err=True
        )


mesh.__doc__ = (mesh.__doc__ or "").format(
    formats=(
        f"Surfaces: {suffixes_by_purpose(SURFACE_FORMATS)}. A tooth as hexahedra: "
        f"{suffixes_by_purpose(VOLUME_FORMATS)}. Gears, teeth and the pair as solids: "
        f"{suffixes_by_purpose(CAD_FORMATS)}. The pair for viewers: {suffixes_by_purpose(SCENE_FORMATS)}. "
        f"The pair in contact as hexahedra: {suffixes_by_purpose(CONTACT_FORMATS)}."
    )
)
command = named(mesh, mesh_options(mesh))
