"""The command `beveloid-geom mesh`: a part of a pair as a file for other programs."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from ..export import CAD_FORMATS, FIELD_FORMATS, MEMBERS, SURFACE_FORMATS, VOLUME_FORMATS
from .options import (
    BUILTIN_DESIGN,
    OVERRIDES,
    Refusal,
    changed_design,
    load_design,
    option_name,
    override_options,
    write_out,
)

if TYPE_CHECKING:
    from ..contact.placing import MeshingPair
    from ..design.model import Design, Member

GEARS, TEETH, FLANKS = (tuple(f"{m}{kind}" for m in MEMBERS) for kind in ("", "-tooth", "-flank"))
PARTS = (*GEARS, "pair", *FLANKS, *TEETH)
ELEMENTS = ("C3D20", "C3D20R", "C3D8I", "C3D8")
UNRESOLVED = "stresses at the contact are not resolved, those of the fillet are"
"""By the mesh, under the pressure of a load."""
HELD = "held at its cut sides: take --teeth 3 for stresses"
"""Of a loaded tooth without a neighbour on both sides, which is too stiff."""
LOAD, LOADED = 1000.0, 6.0
"""N at that module (mm): the default load, which goes with the square of the module for equal stresses."""
STEPS = {"surface": 600.0, "volume": 120.0, "solid": 600.0}
"""Default tolerances in one module, by kind; .step has none."""


@dataclass(frozen=True)
class Request:
    """What is to be written: a `part` as a 'surface', 'volume' or 'solid' in the format `suffix`."""

    part: str
    out: Path
    suffix: str
    kind: str
    tolerance: float
    flank: str
    teeth: int
    bore_radius: float | None
    element: str
    load: float
    fields: tuple[str, ...]
    gear_teeth: int

    @property
    def member(self) -> int:
        """0 for a part of the pinion, 1 for one of the gear."""
        return int(self.part.startswith("gear"))

    @property
    def tooth_count(self) -> int | None:
        """How many teeth, None for a whole gear."""
        return self.teeth if self.part in TEETH else None

    @property
    def whole(self) -> bool:
        """Whether all teeth of the gear are asked for."""
        return self.tooth_count in (None, self.gear_teeth)

    @property
    def posed(self) -> bool:
        """Whether the contact of the flanks is asked for."""
        return self.part == "pair" or self.suffix == ".inp" or bool(self.fields)


def kind_of(part: str, suffix: str) -> str:
    """Whether a part is written in a format as 'surface', 'volume' or 'solid'. Raises Refusal."""
    if part in TEETH and suffix in VOLUME_FORMATS:
        return "volume"
    if suffix in SURFACE_FORMATS:
        return "surface"
    if suffix in CAD_FORMATS and part in (*GEARS, *TEETH):
        return "solid"
    kinds = (
        f"{', '.join(SURFACE_FORMATS)} (surface)",
        f"{', '.join(VOLUME_FORMATS)} (hexahedra of {' or '.join(TEETH)})",
        f"{', '.join(CAD_FORMATS)} (solid of {', '.join((*GEARS, *TEETH))})",
    )
    known = suffix in (*VOLUME_FORMATS, *CAD_FORMATS)
    fault = (
        f"{suffix} holds no {part}" if known else f"{suffix or 'a name without a suffix'} is no known format"
    )
    raise Refusal([f"--out: {fault}; there are {'; '.join(kinds)}"])


def refuse_unused(context: click.Context, request: Request) -> None:
    """Raise Refusal for an option given that changes nothing about what is asked for."""
    teeth, flanks = " and ".join(TEETH), " and ".join(FLANKS)
    mounted = "the pair, a flank with --field, and a tooth as .inp"
    uses = {
        **{name: (request.posed, mounted) for name, _, _ in OVERRIDES if not name.startswith("parabola")},
        "parabola_pinion": (request.posed or request.member == 0, f"the pinion, {mounted}"),
        "parabola_gear": (request.posed or request.member == 1, f"the gear, {mounted}"),
        "flank": (request.posed or request.part in FLANKS, "flanks, the pair, and a tooth as .inp"),
        "teeth": (request.part in TEETH, teeth),
        "bore_radius": (request.part in (*GEARS, *TEETH), ", ".join((*GEARS, *TEETH))),
        "tolerance": (request.kind != "solid", "surfaces and hexahedra"),
        "element": (request.kind == "volume", f"{teeth} as {', '.join(VOLUME_FORMATS)}"),
        "load": (request.suffix == ".inp", f"{teeth} as .inp"),
        "fields": (
            request.part in FLANKS and request.suffix in FIELD_FORMATS,
            f"{flanks} as {', '.join(FIELD_FORMATS)}",
        ),
    }
    faults = [
        f"{'--field' if name == 'fields' else option_name(name)} is for {only}, "
        f"not {request.part} as {request.suffix}"
        for name, (used, only) in uses.items()
        if not used and context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    ]
    if faults:
        raise Refusal(faults)


def check_numbers(request: Request) -> None:
    """Raise Refusal for lengths and forces that cannot be meant."""
    given = (
        ("--tolerance", request.tolerance, "mm", "usual are 0.001 to 0.1"),
        ("--bore-radius", request.bore_radius, "mm", "leave it out for 0.45 of the root radius"),
        ("--load", request.load, "N", "it pushes on the flank, its sign is that of the inward normal"),
    )
    faults = [
        f"{option} must be a finite number above 0 {unit}, got {value:g}: {cure}"
        for option, value, unit, cure in given
        if value is not None and not (math.isfinite(value) and value > 0.0)
    ]
    if faults:
        raise Refusal(faults)


@contextmanager
def written(request: Request) -> Iterator[Path]:
    """A file beside that of the request, which takes its place when all went well. Raises Refusal
    where it cannot be written, where the geometry does not allow it or memory does not suffice."""
    from ..support.whole_file import whole_file

    out, name = request.out, click.format_filename(request.out)
    try:
        if out.is_dir():
            raise Refusal([f"--out: {name} is a folder: name a file in it"])
        if not out.parent.is_dir():
            folder = click.format_filename(out.parent)
            raise Refusal([f"--out: the folder {folder} does not exist: make it first"])
        with whole_file(out) as beside:
            yield beside
    except OSError as error:
        # Libraries that write on their own say no more than that it failed.
        reason = error.strerror or f"{error}, is the disk full?"
        raise Refusal([f"cannot write {name} ({reason}): choose another --out"]) from None
    except MemoryError:
        raise Refusal(
            [f"not enough memory for --tolerance {request.tolerance:g}: take a larger one"]
        ) from None
    except (ValueError, ImportError) as error:
        if isinstance(error, ValueError) and type(error) is not ValueError:
            raise  # as LinAlgError is: no fault of the input
        words = str(error).replace("bore_radius must", "--bore-radius must")
        raise Refusal([words.replace("tolerance must", "--tolerance must")]) from None


def pose(source: str, design: Design, flank: str) -> MeshingPair:
    """The pair in mesh; ClickException (status 1) says why where its flanks have no contact."""
    from ..contact.placing import meshing_pair

    try:
        return meshing_pair(design, flank)
    except ValueError as error:
        from ..report.path import contact_report

        reason = contact_report(source, design, flank, 3, "one-equation").reason
        raise click.ClickException(f"no contact: {reason or error}") from None
    except ArithmeticError as error:
        raise click.ClickException(str(error)) from None


@click.command()
@click.argument("design", default=BUILTIN_DESIGN)
@click.option("--part", type=click.Choice(PARTS), required=True, help="What to write.")
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="FILE", required=True, help="Its suffix is the format."
)
@click.option(
    "--tolerance",
    type=float,
    metavar="MM",
    help="Greatest distance of the mesh from the exact surfaces, of hexahedra that of their straight "
    "edges.  [default: module / 600, hexahedra module / 120: 0.01 and 0.05 at a module of 6 mm]",
)
@click.option(
    "--flank",
    type=click.Choice(["right", "left"]),
    default="right",
    show_default=True,
    help="Which flank; of the pair and of a loaded tooth, the one in contact.",
)
@click.option(
    "--field",
    "fields",
    type=click.Choice(["separation", "pattern"]),
    multiple=True,
    help="Distance of the mating flank on each point of a flank, mm: in the middle of the path of contact, "
    "or the least while the tooth rolls through the mesh. Repeatable.",
)
@click.option(
    "--teeth",
    type=click.IntRange(1),
    metavar="K",
    default=1,
    show_default=True,
    help="Neighbouring teeth, all of them for the whole gear. As .inp they are held in the bore and where "
    "they are cut from the others: take 3 for stresses.",
)
@click.option("--bore-radius", type=float, metavar="MM", help="Default: 0.45 of the least root radius.")
@click.option(
    "--element",
    type=click.Choice(ELEMENTS),
    default=ELEMENTS[0],
    show_default=True,
    help="C3D20R leaves hourglass modes where the contact is smaller than an element, C3D8I fails the patch "
    "test where elements are distorted, C3D8 is stiff in bending.",
)
@click.option(
    "--load",
    type=float,
    metavar="N",
    help="Force on the flank, along its normal, as Hertz's pressure on the ellipse of contact of steel in "
    "the middle of the path.  [default: 1000 * (module / 6 mm)^2]",
)
@override_options
@click.pass_context
def mesh(
    context: click.Context,
    /,
    design: str,
    part: str,
    out: Path,
    tolerance: float | None,
    flank: str,
    fields: tuple[str, ...],
    teeth: int,
    bore_radius: float | None,
    element: str,
    load: float | None,
    **changes: float | None,
) -> None:
    """Write a gear, a tooth, a flank or the pair as a file for other programs.

    Surfaces: .stl, .ply, .obj, and with normals and fields .vtk, .vtp, .vtu. A tooth becomes
    hexahedra with named sets in .inp (for CalculiX, loaded and ready to run), .msh (Gmsh), .bdf
    (Nastran) and .vtu. Gears and teeth as solids: .step. Lengths are mm, in the gear's own frame;
    the pair stands in S_f in the middle of its path of contact.
    """
    suffix = out.suffix.lower()
    kind = kind_of(part, suffix)
    changed = changed_design(load_design(design), changes)
    member = changed.members[part.startswith("gear")]
    module = float(member.tool.normal_module)
    request = Request(
        part,
        out,
        suffix,
        kind,
        module / STEPS[kind] if tolerance is None else tolerance,
        flank,
        teeth,
        bore_radius,
        element,
        LOAD * (module / LOADED) ** 2 if load is None else load,
        tuple(dict.fromkeys(fields)),
        int(member.teeth),
    )
    refuse_unused(context, request)
    check_numbers(request)
    source = click.format_filename(design)
    if teeth > request.gear_teeth:
        raise Refusal([f"--teeth must be between 1 and {request.gear_teeth}, got {teeth}"])
    if part in FLANKS:
        warn_of_undercut(changed.members[request.member], flank)
    from tqdm import tqdm

    write = {"surface": write_surface_part, "volume": write_volume_part, "solid": write_solid_part}[kind]
    with written(request) as beside, tqdm(total=2, disable=None, leave=False, file=sys.stderr) as bar:
        told = write(source, changed, request, beside, bar)
    write_out(f"{click.format_filename(out)}: {told}\n")


def warn_of_undercut(member: Member, flank: str) -> None:
    """A line on standard error where the tool leaves less of a flank than is written."""
    from ..gear.undercut import undercut_of, words_of

    try:
        found = undercut_of(member, flank)
    except ValueError as error:
        click.echo(f"Warning: {error}", err=True)
        return
    if found.undercut:
        click.echo(f"Warning: the {flank} flank is undercut {words_of(found)}; it is written whole", err=True)


def write_surface_part(source: str, design: Design, request: Request, path: Path, bar: Any) -> str:
    """Build and write a surface; what is to be told about it."""
    from ..export import parts
    from ..export.surfaces import write_surface
    from ..shapes.solid import NAMES

    posed = pose(source, design, request.flank) if request.posed else None
    member, tolerance = design.members[request.member], request.tolerance
    bar.set_description(request.part)
    if request.part == "pair":
        assert posed is not None
        surface = parts.pair_surface(design, posed, request.suffix, tolerance)
    elif request.part in FLANKS:
        surface = parts.flank_part(design, request.member, request.flank, tolerance, posed, request.fields)
    else:
        surface = parts.gear_surface(
            member, request.suffix, tolerance, request.tooth_count, request.bore_radius
        )
    bar.update()
    bar.set_description(f"write {request.out.name}")
    write_surface(surface, path, request.suffix, f"{request.part} of {Path(source).name}, mm")
    bar.update()
    told = f"{len(surface.faces):,} triangles, {len(surface.points):,} points"
    if request.suffix in FIELD_FORMATS and "part" in surface.cell_fields:
        told += f"; part: {', '.join(f'{number} {name}' for number, name in enumerate(NAMES))}"
    return told


def write_volume_part(source: str, design: Design, request: Request, path: Path, bar: Any) -> str:
    """Build and write hexahedra; what is to be told about them."""
    from ..export import parts
    from ..export.volumes import write_volume
    from ..shapes.elements import element_shapes
    from ..shapes.hexahedra import tooth_hexahedra
    from ..shapes.outline import counted

    posed = pose(source, design, request.flank) if request.posed else None
    member, loaded = request.member, (request.teeth - 1) // 2
    bar.set_description(request.part)
    mesh = tooth_hexahedra(
        design.members[member], request.teeth, request.element, request.tolerance, request.bore_radius
    )
    bar.update()
    bar.set_description(f"write {request.out.name}")
    told = f"{len(mesh.hexahedra):,} hexahedra {request.element}, {len(mesh.points):,} nodes"
    told += f", scaled Jacobian {element_shapes(mesh)[0].min():.2f} or more"
    comment = [f"{request.part} of {source}, {counted(request.teeth)}, edges within {request.tolerance:g} mm"]
    case = None
    if posed is not None:
        case = parts.contact_case(mesh, design, posed, member, request.load, loaded)
        place = ", ".join(f"{x:.4f}" for x in case.load.point)
        where = f"{request.load:g} N on the {request.flank} flank of tooth {loaded + 1} of {request.teeth}"
        where += f" at ({place}) mm"
        comment += [f"{where}, the middle of the path of contact", f"{case.load.told}.", f"{UNRESOLVED}."]
        told += f"; {where}, {case.load.told}; {UNRESOLVED}"
        if request.teeth < 3 and not request.whole:
            comment.append(f"The loaded tooth is {HELD}.")
            told += f"; {HELD}"
        told += f"; run: {ccx_command(request.out)}"
    write_volume(mesh, path, request.element, case=case, comment=comment, suffix=request.suffix)
    bar.update()
    return told


def ccx_command(deck: Path) -> str:
    """What to type for CalculiX to solve a deck. It takes the name without `.inp`, which it adds in small
    letters, and leaves its files where it is started."""
    command = f"ccx -i {shlex.quote(deck.stem)}"
    if deck.suffix != ".inp":
        command = f"mv {shlex.quote(deck.name)} {shlex.quote(deck.stem + '.inp')} && {command}"
    return command if deck.parent == Path() else f"cd {shlex.quote(str(deck.parent))} && {command}"


def write_solid_part(_: str, design: Design, request: Request, path: Path, bar: Any) -> str:
    """Build and write a solid; what is to be told about it."""
    from ..export.step import write_step
    from ..shapes.outline import counted

    member = design.members[request.member]
    numbers = None if request.tooth_count is None else range(request.tooth_count)
    bar.set_description(f"{request.part} as a solid")
    write_step(member, path, numbers, request.bore_radius, MEMBERS[request.member])
    bar.update(2)
    return f"a solid with {counted(int(member.teeth) if numbers is None else len(numbers))}"
