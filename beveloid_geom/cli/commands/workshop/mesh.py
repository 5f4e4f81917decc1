"""The command `beveloid-geom mesh`: a part of a pair as a file for other programs."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from ....export import (
    CAD_FORMATS,
    CONTACT_FORMATS,
    FIELD_FORMATS,
    MEMBERS,
    SCENE_FORMATS,
    SURFACE_FORMATS,
    VOLUME_FORMATS,
    suffixes_by_purpose,
)
from ...mesh_parts import FLANKS, GEARS, TEETH, WRITE, Request, frames_in_mesh
from ...options import (
    BUILTIN_DESIGN,
    OVERRIDES,
    SIDES,
    Refusal,
    block,
    changed_design,
    load_design,
    option,
    option_name,
    override_options,
    write_out,
)
from ...results import named, refused_values

if TYPE_CHECKING:
    from ....design.model import Design, Member

PARTS = (*GEARS, "pair", *FLANKS, *TEETH)
ELEMENTS = ("C3D20", "C3D20R", "C3D8I", "C3D8")
LOAD, LOADED = 1000.0, 6.0
"""N at that module (mm): the default load, which goes with the square of the module for equal stresses."""


@dataclass(frozen=True)
class Kind:
    """Geometry of one kind: its `formats`, the `parts` that it is made of, the words for it in a refusal,
    and how many default tolerances are one module, None where it does without."""

    formats: dict[str, Any]
    parts: tuple[str, ...]
    words: str
    steps: float | None = 600.0


KINDS = {
    "volume": Kind(VOLUME_FORMATS, TEETH, f"hexahedra of {' or '.join(TEETH)}", 120.0),
    "contact": Kind(CONTACT_FORMATS, ("pair",), "the pair in contact", None),
    "surface": Kind(SURFACE_FORMATS, PARTS, "surface"),
    "solid": Kind(CAD_FORMATS, (*GEARS, *TEETH, "pair"), f"solid of {', '.join((*GEARS, *TEETH, 'pair'))}"),
    "scene": Kind(SCENE_FORMATS, ("pair",), "the pair to look at, with paths and patterns", 200.0),
}
"""In the order in which they are tried: a tooth as .vtu is hexahedra."""


FORMATS = (
    f"Surfaces: {suffixes_by_purpose(SURFACE_FORMATS)}. A tooth as hexahedra: "
    f"{suffixes_by_purpose(VOLUME_FORMATS)}. Gears, teeth and the pair as solids: "
    f"{suffixes_by_purpose(CAD_FORMATS)}. The pair to look at: {suffixes_by_purpose(SCENE_FORMATS)}. "
    f"The pair in contact as hexahedra: {suffixes_by_purpose(CONTACT_FORMATS)}."
)
PATH: Any = click.Path(path_type=Path)
TOLERANCE = (
    "Greatest distance of the mesh from the exact surfaces, of hexahedra that of their straight edges."
    "  [default: module / 600, to look at module / 200, hexahedra module / 120: 0.01, 0.03, 0.05 at 6 mm; "
    "of the pair as .inp the flanks that touch are finer, and all else is coarse unless this is given]"
)
NEIGHBOURS = (
    "Neighbouring teeth, all of them for the whole gear. As .inp they are held in the bore and where they "
    "are cut from the others: take 3 for stresses. Of each member of the pair in contact an odd number.  "
    "[default: 1, of the pair 3]"
)
ELEMENT = (
    "C3D20R leaves hourglass modes where the contact is smaller than an element, C3D8I fails the patch test "
    "where elements are distorted, C3D8 is stiff in bending."
)
FORCE = (
    "Force on the flank, along its normal, as Hertz's pressure on the ellipse of contact of steel in the "
    "middle of the path.  [default: 1000 * (module / 6 mm)^2]"
)
TORQUE = (
    "Torque on the pinion of the pair as .inp; the gear is held.  "
    "[default: that of 20 kN * (module / 6 mm)^2 between the teeth]"
)
ROLL = "Roll of the pinion of the pair as .inp, at which it touches first.  [default: the middle of its path]"
ROLLS = "So many rolls over a pitch about the middle in place of one, a file each: pair-1.inp, pair-2.inp ..."
ACROSS = (
    "Elements across the ellipse of contact of the pair as .inp; 4 for pressures, 1 for load sharing and "
    "transmission error."
)
FLANK = "Which flank; of the pair and of a loaded tooth, the one in contact."
FIELD = (
    "Distance of the mating flank on each point of a flank, mm: in the middle of the path of contact, or the "
    "least while the tooth rolls through the mesh. Repeatable."
)
PLACED = "Write a single gear, tooth or flank where it stands in the pair in mesh, not in its own frame."
FRAMES = (
    "Print how the gears stand in mesh, as matrices from their own frames to the pair's; without --out "
    "nothing is written."
)
OPTIONS = block(
    click.argument("design", default=BUILTIN_DESIGN),
    click.option("--part", type=click.Choice(PARTS), help="What to write."),
    click.option("--out", type=PATH, metavar="FILE", help="Its suffix is the format."),
    click.option("--placed", is_flag=True, help=PLACED),
    click.option("--frames", is_flag=True, help=FRAMES),
    option("--tolerance", float, None, TOLERANCE, "MM"),
    option("--flank", SIDES, SIDES.choices[0], FLANK),
    click.option("--field", type=click.Choice(["separation", "pattern"]), multiple=True, help=FIELD),
    option("--teeth", click.IntRange(1), None, NEIGHBOURS, "K"),
    option("--bore-radius", float, None, "Default: 0.45 of the least root radius.", "MM"),
    option("--element", click.Choice(ELEMENTS), ELEMENTS[0], ELEMENT),
    option("--load", float, None, FORCE, "N"),
    option("--torque", float, None, TORQUE, "NM"),
    option("--across", float, 4.0, ACROSS, "N"),
    option("--roll-deg", float, None, ROLL, "DEG"),
    option("--rolls", click.IntRange(1, 1000), None, ROLLS, "N"),
    override_options,
    click.pass_context,
)


def kind_of(part: str, suffix: str) -> str:
    """Find the kind, a key of KINDS, as which a part is written in a format. Raises Refusal."""
    for name, kind in KINDS.items():
        if part in kind.parts and suffix in kind.formats:
            return name
    known = any(suffix in kind.formats for kind in KINDS.values())
    shown = suffix or "a name without a suffix"
    kinds = "; ".join(f"{', '.join(kind.formats)} ({kind.words})" for kind in KINDS.values())
    fault = f"a {part} cannot be written as {suffix}" if known else f"{shown} is no known format"
    raise Refusal([f"--out: {fault}: give one of {kinds}"])


def refuse_unused(context: click.Context, request: Request) -> None:
    """Raise Refusal for an option given that changes nothing about what is asked for."""
    teeth, flanks, solids = " and ".join(TEETH), " and ".join(FLANKS), (*GEARS, *TEETH)
    posed, part, suffix = request.posed, request.part, request.suffix
    contact = request.kind == "contact"
    mounted = "the pair, a part --placed, a flank with --field, and a tooth as .inp"
    uses = {
        **{name: (posed, mounted) for name, *_ in OVERRIDES},
        "parabola_pinion": (posed or request.number == 0, f"the pinion, {mounted}"),
        "parabola_gear": (posed or request.number == 1, f"the gear, {mounted}"),
        "flank": (posed or part in FLANKS, f"flanks, {mounted}"),
        "placed": (part != "pair", ", ".join((*GEARS, *TEETH, *FLANKS))),
        "teeth": (part in TEETH or contact, f"{teeth}, and the pair as .inp"),
        "bore_radius": (part in solids or contact, f"{', '.join(solids)}, and the pair as .inp"),
        **dict.fromkeys(("torque", "across", "roll_deg", "rolls"), (contact, "the pair as .inp")),
        "tolerance": (request.kind != "solid", "surfaces and hexahedra"),
        "element": (request.kind == "volume", f"{teeth} as {', '.join(VOLUME_FORMATS)}"),
        "load": (suffix == ".inp" and not contact, f"{teeth} as .inp"),
        "field": (part in FLANKS and suffix in FIELD_FORMATS, f"{flanks} as {', '.join(FIELD_FORMATS)}"),
    }
    faults = [
        f"{option_name(name)} is for {only}, not {part} as {suffix}"
        for name, (used, only) in uses.items()
        if not used and context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    ]
    if faults:
        raise Refusal(faults)


def check_numbers(request: Request) -> None:
    """Raise Refusal for lengths, forces and teeth that cannot be meant."""
    given = (
        ("--tolerance", request.tolerance, "mm", "usual are 0.001 to 0.1"),
        ("--bore-radius", request.bore_radius, "mm", "leave it out for 0.45 of the root radius"),
        ("--load", request.load, "N", "it pushes on the flank, its sign is that of the inward normal"),
        ("--across", request.across, "", "4 show pressures"),
        ("--torque", request.torque, "N m", "it presses the flanks of --flank together, right or left"),
    )
    faults = [
        f"{option} must be a finite number above 0{unit and ' '}{unit}, got {value:g}: {cure}"
        for option, value, unit, cure in given
        if value is not None and not (math.isfinite(value) and value > 0.0)
    ]
    if request.roll_deg is not None and not math.isfinite(request.roll_deg):
        faults.append(f"--roll-deg must be a finite number of deg, got {request.roll_deg:g}")
    if request.rolls is not None and request.roll_deg is not None:
        faults.append("--roll-deg and --rolls exclude each other: give one of them")
    if request.teeth > request.member.teeth:
        faults.append(f"--teeth must be between 1 and {int(request.member.teeth)}, got {request.teeth}")
    if faults:
        raise Refusal(faults)


def file_beside(out: Path) -> AbstractContextManager[Path]:
    """Give `whole_file` of a file. Raises Refusal for a folder, and for a file in none."""
    from ....support.whole_file import whole_file

    if out.is_dir():
        raise Refusal([f"--out: {click.format_filename(out)} is a folder: name a file in it"])
    if not out.parent.is_dir():
        folder = click.format_filename(out.parent)
        raise Refusal([f"--out: the folder {folder} does not exist: make it first"])
    return whole_file(out)


@contextmanager
def refused_writing(request: Request) -> Iterator[None]:
    """Raise Refusal where the file of the request cannot be written, where the geometry does not allow it or
    memory does not suffice; ClickException (status 1) where a pattern has no first contact."""
    from ....operation.marking.operating_rolls import UnknownOperationError
    from ....support.argument import ArgumentError

    try:
        with refused_values():
            yield
    except OSError as error:
        # Libraries that write on their own say no more than that it failed.
        reason = error.strerror or f"{error}, is the disk full?"
        name = click.format_filename(error.filename2 or request.out)  # the first where it takes its place
        raise Refusal([f"cannot write {name} ({reason}): choose another --out"]) from None
    except MemoryError:
        cure = "the pair in contact: take a smaller --across or fewer --teeth"
        if request.tolerance is not None:
            cure = f"--tolerance {request.tolerance:g}: take a larger one"
        raise Refusal([f"not enough memory for {cure}"]) from None
    except ArgumentError as error:
        raise Refusal([f"{option_name(error.argument)} {error.text}"]) from None
    except UnknownOperationError as error:
        what = "contact" if request.kind == "contact" else "pattern"
        raise click.ClickException(f"no {what}: {error.reason}") from None  # status 1
    except ImportError as error:
        raise Refusal([str(error)]) from None


def mesh(context: click.Context, /, design: str, field: tuple[str, ...], **given: Any) -> None:
    """Write a gear, a tooth, a flank or the pair as a file for other programs.

    {formats}

    Surfaces for ParaView have exact normals and fields. Hexahedra have named sets, and as .inp a load and
    supports, ready to run. Lengths are mm, in the gear's own frame; the pair, and what is --placed, stands in
    S_f (z along the pinion's axis, x along the common perpendicular) in the middle of its path of contact.

    Of the pair in contact the gear is held and a torque turns the pinion; what ccx finds over a pitch
    `render-figures --loaded` draws.
    """
    if not (given["frames"] and given["part"] is None and given["out"] is None):
        require_part_and_out(context)
    changed = changed_design(load_design(design), {name: given.pop(name) for name, *_ in OVERRIDES})
    if given.pop("frames"):
        write_out(frames_in_mesh(changed, given["flank"]))
    if given["part"] is not None:
        write_part(context, changed, click.format_filename(design), field, given)


def require_part_and_out(context: click.Context) -> None:
    """Raise MissingParameter where one of --part and --out is not given."""
    for parameter in context.command.params:
        if parameter.name in ("part", "out") and context.params[parameter.name] is None:
            raise click.MissingParameter(ctx=context, param=parameter)


def write_part(
    context: click.Context, changed: Design, source: str, field: tuple[str, ...], given: dict[str, Any]
) -> None:
    """Write the part that the options ask for, and say what it is."""
    part, suffix = given["part"], given["out"].suffix.lower()
    kind = kind_of(part, suffix)
    module = float(changed.members[part.startswith(MEMBERS[1])].tool.normal_module)
    load, teeth = LOAD * (module / LOADED) ** 2, 3 if kind == "contact" else 1
    steps = KINDS[kind].steps
    defaults = {"tolerance": None if steps is None else module / steps, "load": load, "teeth": teeth}
    given |= {name: value for name, value in defaults.items() if given[name] is None}
    fields = tuple(dict.fromkeys(field))
    request = Request(source, changed, suffix, kind, fields=fields, **given)
    refuse_unused(context, request)
    check_numbers(request)
    if part in FLANKS:
        warn_of_undercut(request.member, request.flank)
    from tqdm import tqdm

    each = request.each
    bar = tqdm(total=2 * len(each), disable=None, leave=False, file=sys.stderr)
    with bar, refused_writing(request), ExitStack() as files:  # which take their places when all are written
        places, told = [], []
        for one in each:
            with refused_writing(one):
                places.append(files.enter_context(file_beside(one.out)))
        for one, beside in zip(each, places, strict=True):
            bar.set_description(part)
            with refused_writing(one):
                text = WRITE[kind](one, beside, bar)
            told.append(f"{click.format_filename(one.out)}: {text}\n")
    write_out("".join(told))


def warn_of_undercut(member: Member, flank: str) -> None:
    """Write a line on standard error where the tool leaves less of a flank than is written."""
    from ....gear.undercut import undercut_of, words_of

    try:
        found = undercut_of(member, flank)
    except ValueError as error:
        click.echo(f"Warning: {error}", err=True)
        return
    if found.undercut:
        click.echo(f"Warning: the {flank} flank is undercut {words_of(found)}; it is written whole", err=True)


mesh.__doc__ = str(mesh.__doc__).format(formats=FORMATS)
command = named(mesh, OPTIONS(mesh))
