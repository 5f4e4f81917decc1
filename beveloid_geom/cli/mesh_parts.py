"""The parts that `beveloid-geom mesh` writes: how each is built, and what is told about it."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..export import CAD_FORMATS, FIELD_FORMATS, MEMBERS, writer_of

if TYPE_CHECKING:
    from ..contact.placing import MeshingPair
    from ..design.model import Design, Member

GEARS, TEETH, FLANKS = (tuple(f"{m}{kind}" for m in MEMBERS) for kind in ("", "-tooth", "-flank"))
UNRESOLVED = "stresses at the contact are not resolved, those of the fillet are"
"""By the mesh, under the pressure of a load."""
HELD = "held at its cut sides: take --teeth 3 for stresses"
"""Of a loaded tooth without a neighbour on both sides, which is too stiff."""


@dataclass(frozen=True)
class Request:
    """What is to be written: a `part` of a `design` from the file `source`, as a 'surface', 'volume' or
    'solid' in the format `suffix`; lengths in mm, the `load` in N."""

    source: str
    design: Design
    suffix: str
    kind: str
    part: str
    out: Path
    tolerance: float
    flank: str
    teeth: int
    bore_radius: float | None
    element: str
    load: float
    fields: tuple[str, ...]

    @property
    def number(self) -> int:
        """0 for a part of the pinion, 1 for one of the gear."""
        return int(self.part in (GEARS[1], TEETH[1], FLANKS[1]))

    @property
    def member(self) -> Member:
        """The gear of which something is written."""
        return self.design.members[self.number]

    @property
    def tooth_count(self) -> int | None:
        """How many teeth, None for a whole gear."""
        return self.teeth if self.part in TEETH else None

    @property
    def posed(self) -> bool:
        """Whether the contact of the flanks is asked for."""
        return self.part == "pair" or self.suffix == ".inp" or bool(self.fields)


def pose(request: Request) -> MeshingPair | None:
    """Find the pair in mesh where it is asked for; ClickException (status 1) says why where its flanks have
    no contact."""
    from ..contact.placing import meshing_pair

    if not request.posed:
        return None
    try:
        return meshing_pair(request.design, request.flank)
    except ValueError as error:
        from ..contact.path import path_of_contact
        from ..findings.path import reason_of

        reason = reason_of(path_of_contact(request.design, request.flank, 3))
        raise click.ClickException(f"no contact: {reason or error}") from None
    except ArithmeticError as error:
        raise click.ClickException(str(error)) from None


def begin_writing(request: Request, bar: Any) -> None:
    """Show that the part is made and is written now."""
    bar.update()
    bar.set_description(f"write {request.out.name}")


def write_surface_part(request: Request, path: Path, bar: Any) -> str:
    """Build and write a surface; what is to be told about it."""
    from ..export import parts
    from ..export.surfaces import write_surface
    from ..shapes.solid import NAMES

    posed, suffix, tolerance = pose(request), request.suffix, request.tolerance
    if request.part in FLANKS:
        surface = parts.flank_part(
            request.design, request.number, request.flank, tolerance, posed, request.fields
        )
    elif posed is not None:
        surface = parts.pair_surface(request.design, posed, suffix, tolerance)
    else:
        surface = parts.gear_surface(
            request.member, suffix, tolerance, request.tooth_count, request.bore_radius
        )
    begin_writing(request, bar)
    write_surface(surface, path, suffix, f"{request.part} of {Path(request.source).name}, mm")
    told = f"{len(surface.faces):,} triangles, {len(surface.points):,} points"
    if suffix in FIELD_FORMATS and "part" in surface.cell_fields:
        told += f"; part: {', '.join(f'{number} {name}' for number, name in enumerate(NAMES))}"
    return told


def write_volume_part(request: Request, path: Path, bar: Any) -> str:
    """Build and write hexahedra; what is to be told about them."""
    from ..export import parts
    from ..export.volumes import write_volume
    from ..shapes.elements import element_shapes
    from ..shapes.hexahedra import tooth_hexahedra
    from ..shapes.outline import counted

    posed, member = pose(request), request.member
    teeth, element, loaded = request.teeth, request.element, (request.teeth - 1) // 2
    mesh = tooth_hexahedra(member, teeth, element, request.tolerance, request.bore_radius)
    begin_writing(request, bar)
    told = f"{len(mesh.hexahedra):,} hexahedra {element}, {len(mesh.points):,} nodes"
    told += f", scaled Jacobian {element_shapes(mesh)[0].min():.2f} or more"
    comment = [f"{request.part} of {request.source}, {counted(teeth)}, edges within {request.tolerance:g} mm"]
    case = None
    if posed is not None:
        case = parts.contact_case(mesh, request.design, posed, request.number, request.load, loaded)
        place = ", ".join(f"{x:.4f}" for x in case.load.point)
        where = f"{request.load:g} N on the {request.flank} flank of tooth {loaded + 1} of {teeth}"
        where += f" at ({place}) mm"
        comment += [f"{where}, the middle of the path of contact", f"{case.load.told}.", f"{UNRESOLVED}."]
        told += f"; {where}, {case.load.told}; {UNRESOLVED}"
        if teeth < min(3, member.teeth):
            comment.append(f"The loaded tooth is {HELD}.")
            told += f"; {HELD}"
        told += f"; run: {ccx_command(request.out)}"
    write_volume(mesh, path, element, case=case, comment=comment, suffix=request.suffix)
    return told


def ccx_command(deck: Path) -> str:
    """Give what to type for CalculiX to solve a deck. It takes the name without `.inp`, which it adds in
    small letters, and leaves its files where it is started."""
    command = f"ccx -i {shlex.quote(deck.stem)}"
    if deck.suffix != ".inp":
        command = f"mv {shlex.quote(deck.name)} {shlex.quote(deck.stem + '.inp')} && {command}"
    return command if deck.parent == Path() else f"cd {shlex.quote(str(deck.parent))} && {command}"


def write_solid_part(request: Request, path: Path, _: Any) -> str:
    """Build and write a solid; what is to be told about it."""
    from ..shapes.outline import counted

    member = request.member
    numbers = None if request.tooth_count is None else range(request.tooth_count)
    write = writer_of(CAD_FORMATS, request.suffix)
    write(member, path, numbers, request.bore_radius, MEMBERS[request.number])
    return f"a solid with {counted(int(member.teeth) if numbers is None else len(numbers))}"


WRITE = {"surface": write_surface_part, "volume": write_volume_part, "solid": write_solid_part}
"""By the kind of a request."""
