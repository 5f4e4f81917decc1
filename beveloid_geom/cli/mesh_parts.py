"""The parts that `beveloid-geom mesh` writes: how each is built, and what is told about it."""

from __future__ import annotations

import math
import shlex
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..export import (
    ASSEMBLY_FORMATS,
    CAD_FORMATS,
    CONTACT_FORMATS,
    FIELD_FORMATS,
    FIXED_FRAME,
    MEMBERS,
    OWN_FRAME,
    SCENE_FORMATS,
    UNITS,
    writer_of,
)
from .options import Refusal

if TYPE_CHECKING:
    from ..contact.placing import Frame, MeshingPair
    from ..design.model import Design, Member

GEARS, TEETH, FLANKS = (tuple(f"{m}{kind}" for m in MEMBERS) for kind in ("", "-tooth", "-flank"))
UNRESOLVED = "stresses at the contact are not resolved, those of the fillet are"
"""By the mesh, under the pressure of a load."""
PRESSED = 20e3
"""N between the teeth of a pair of 6 mm module: its default load goes with the square of the module."""
HELD = "held at its cut sides: take --teeth 3 for stresses"
"""Of a loaded tooth without a neighbour on both sides, which is too stiff."""


@dataclass(frozen=True)
class Request:
    """What is to be written: a `part` of a `design` from the file `source`, as a 'surface', 'volume',
    'contact', 'solid' or 'scene' in the format `suffix`; lengths in mm, the `load` in N, the `torque` in N m;
    elements `across` the contact; `rolls`: how many over a pitch, in place of one; `placed`: in S_f as in
    mesh, not in the gear's own frame."""

    source: str
    design: Design
    suffix: str
    kind: str
    part: str
    out: Path
    tolerance: float | None
    flank: str
    teeth: int
    bore_radius: float | None
    element: str
    load: float
    torque: float | None
    across: float
    roll_deg: float | None
    rolls: int | None
    placed: bool
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
    def within(self) -> float:
        """The tolerance, mm, which only the pair in contact can do without."""
        assert self.tolerance is not None
        return self.tolerance

    @property
    def posed(self) -> bool:
        """Whether the contact of the flanks is asked for."""
        return self.part == "pair" or self.suffix == ".inp" or self.placed or bool(self.fields)

    @property
    def pose(self) -> MeshingPair | None:
        """The pair in mesh where it is asked for; raises as `pose` does."""
        return pose(self.design, self.flank) if self.posed else None

    @property
    def frame(self) -> Frame | None:
        """The frame in which a single part is written, None for its own."""
        return self.pose.frames[self.number] if self.pose is not None and self.placed else None

    @property
    def each(self) -> list[Request]:
        """The same by roll of the pinion, if several are asked for: files with numbers. Raises Refusal where
        they reach beyond the path of contact."""
        from ..export.fea.pair_mesh import rolls_in_mesh

        if self.rolls is None:
            return [self]
        posed = pose(self.design, self.flank)
        pitch, middle = 360.0 / float(self.design.pinion.teeth), math.degrees(float(posed.roll[0]))
        least, greatest = map(math.degrees, rolls_in_mesh(posed))
        beside = min(greatest - middle, middle - least) / pitch
        if 0.5 - 0.5 / self.rolls > beside:  # pitches from the middle to the last roll
            text = f"as tooth pair 0 is in mesh over {2.0 * beside:.4g} pitches only, got {self.rolls}"
            most = int(1.0 / (1.0 - 2.0 * beside))
            raise Refusal([f"--rolls must be at most {most}, {text}: or give each roll by --roll-deg"])
        digits = len(str(self.rolls))
        return [
            replace(
                self,
                out=self.out.with_stem(f"{self.out.stem}-{k + 1:0{digits}}"),
                roll_deg=middle + pitch * ((k + 0.5) / self.rolls - 0.5),
            )
            for k in range(self.rolls)
        ]


def pose(design: Design, flank: str) -> MeshingPair:
    """Find the pair in mesh; ClickException (status 1) says why where its flanks have no contact."""
    from ..contact.placing import meshing_pair

    try:
        return meshing_pair(design, flank)
    except ValueError as error:
        from ..contact.path import path_of_contact
        from ..findings.path import reason_of

        reason = reason_of(path_of_contact(design, flank, 3))
        raise click.ClickException(f"no contact: {reason or error}") from None
    except ArithmeticError as error:
        raise click.ClickException(str(error)) from None


def frames_in_mesh(design: Design, flank: str) -> str:
    """Say how the gears stand in mesh, as matrices (4, 4) that carry their own frames to S_f, mm."""
    import numpy as np

    lines = []
    for name, (rotation, origin) in zip(MEMBERS, pose(design, flank).frames, strict=True):
        lines.append(f"{name}, from its own frame to S_f, mm:")
        rows = np.vstack((np.column_stack((rotation, origin)), (0.0, 0.0, 0.0, 1.0)))
        lines += [" ".join(f"{value:22.15g}" for value in row) for row in rows.tolist()]
    return "\n".join(lines) + "\n"


def begin_writing(request: Request, bar: Any) -> None:
    """Show that the part is made and is written now."""
    bar.update()
    bar.set_description(f"write {request.out.name}")


def write_surface_part(request: Request, path: Path, bar: Any) -> str:
    """Build and write a surface; what is to be told about it."""
    from ..export import parts
    from ..export.surfaces import in_fixed, write_surface
    from ..shapes.solid import NAMES

    posed, suffix, tolerance = request.pose, request.suffix, request.within
    if request.part in FLANKS:
        surface = parts.flank_part(
            request.design, request.number, request.flank, tolerance, posed, request.fields
        )
    elif request.part == "pair" and posed is not None:
        surface = parts.pair_surface(request.design, posed, suffix, tolerance)
    else:
        surface = parts.gear_surface(
            request.member, suffix, tolerance, request.tooth_count, request.bore_radius
        )
    if request.frame is not None:
        surface = in_fixed(surface, request.frame)
    begin_writing(request, bar)
    write_surface(surface, path, suffix, f"{request.part} of {Path(request.source).name}, mm")
    told = f"{len(surface.faces):,} triangles, {len(surface.points):,} points"
    if suffix in FIELD_FORMATS and "part" in surface.cell_fields:
        told += f"; part: {', '.join(f'{number} {name}' for number, name in enumerate(NAMES))}"
    return told


def write_volume_part(request: Request, path: Path, bar: Any) -> str:
    """Build and write hexahedra; what is to be told about them."""
    from ..export import parts
    from ..export.fea.volumes import write_volume
    from ..shapes.elements import element_shapes
    from ..shapes.hexahedra import tooth_hexahedra
    from ..shapes.outline import counted

    posed, member = request.pose, request.member
    teeth, element, loaded = request.teeth, request.element, (request.teeth - 1) // 2
    mesh = tooth_hexahedra(member, teeth, element, request.within, request.bore_radius)
    begin_writing(request, bar)
    told = f"{len(mesh.hexahedra):,} hexahedra {element}, {len(mesh.points):,} nodes"
    told += f", scaled Jacobian {element_shapes(mesh)[0].min():.2f} or more"
    comment = [f"{request.part} of {request.source}, {counted(teeth)}, edges within {request.within:g} mm"]
    case = None
    if posed is not None and request.suffix == ".inp":
        case = parts.contact_case(mesh, request.design, posed, request.number, request.load, loaded)
    if request.frame is not None:
        mesh, case = parts.placed_volume(mesh, case, request.frame)
    if case is not None:
        place = ", ".join(f"{x:.4f}" for x in case.load.point)
        where = f"{request.load:g} N on the {request.flank} flank of tooth {loaded + 1} of {teeth}"
        where += f" at ({place}) mm"
        comment += [f"{where}, the middle of the path of contact", f"{case.load.told}.", f"{UNRESOLVED}."]
        told += f"; {where}, {case.load.told}; {UNRESOLVED}"
        if teeth < min(3, member.teeth):
            comment.append(f"The loaded tooth is {HELD}.")
            told += f"; {HELD}"
        told += f"; run: {ccx_command(request.out)}"
    frame = FIXED_FRAME if request.placed else OWN_FRAME
    write_volume(mesh, path, element, case=case, comment=comment, suffix=request.suffix, frame=frame)
    return told


def write_contact_part(request: Request, path: Path, bar: Any) -> str:
    """Build and write the pair in contact; what is to be told about it."""
    from ..export.fea.pair_mesh import ELEMENT, lever_of, pair_mesh
    from ..report.words import failure_of
    from ..shapes.outline import counted

    design, posed = request.design, request.pose
    assert posed is not None  # the pair always has one
    if jammed := failure_of(None, design):
        raise click.ClickException(jammed)
    lever, size = lever_of(design), float(design.pinion.tool.normal_module) / 6.0
    torque = 1e-3 * PRESSED * size**2 * lever if request.torque is None else request.torque
    force = 1e3 * torque / lever
    pair = pair_mesh(
        design,
        posed,
        None if request.roll_deg is None else math.radians(request.roll_deg),
        teeth=request.teeth,
        force=force,
        across=request.across,
        tolerance=request.tolerance,
        bore_radius=request.bore_radius,
    )
    begin_writing(request, bar)
    where = f"{torque:.6g} N m on the pinion at a roll of {math.degrees(pair.roll[0]):.4f} deg"
    fine = f"{pair.across:.2g} elements across the ellipse of contact of {force:.4g} N"
    comment = [f"pair of {request.source}, {counted(request.teeth)} of each", where, fine, FIXED_FRAME, UNITS]
    write = writer_of(CONTACT_FORMATS, request.suffix)
    write(path, design, pair, 1e3 * torque, comment, request.rolls or 1)
    told = f"{len(pair.mesh.hexahedra):,} hexahedra {ELEMENT}, {len(pair.mesh.points):,} nodes"
    return f"{told}; {where}, {request.flank} flanks; {fine}; run: {ccx_command(request.out)}"


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
    if request.part == "pair" and request.pose is not None:
        writer_of(ASSEMBLY_FORMATS, request.suffix)(request.design, path, request.pose.frames)
        return f"an assembly of {' and '.join(MEMBERS)}"
    numbers = None if request.tooth_count is None else range(request.tooth_count)
    write = writer_of(CAD_FORMATS, request.suffix)
    write(member, path, numbers, request.bore_radius, MEMBERS[request.number], request.frame)
    return f"a solid with {counted(int(member.teeth) if numbers is None else len(numbers))}"


def write_scene_part(request: Request, path: Path, bar: Any) -> str:
    """Build and write the pair to look at, with paths and patterns; what is to be told about it."""
    from ..export.scene import pair_pieces

    assert request.pose is not None  # the pair always has one
    pieces = pair_pieces(request.design, request.pose, request.within)
    begin_writing(request, bar)
    writer_of(SCENE_FORMATS, request.suffix)(pieces, path)
    faces = sum(len(piece.surface.faces) for piece in pieces)
    return f"{faces:,} triangles in m, y up: {', '.join(piece.name for piece in pieces)}"


WRITE = {
    "surface": write_surface_part,
    "volume": write_volume_part,
    "contact": write_contact_part,
    "solid": write_solid_part,
    "scene": write_scene_part,
}
"""By the kind of a request."""
