"""Parts that `beveloid-geom mesh` writes.

Each function `write_..._part` builds and writes one kind of geometry and returns the message for the user.
"""

from __future__ import annotations

import math
import shlex
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..export import (
    ASSEMBLY_FORMATS,
    CAD_FORMATS,
    CONTACT_FORMATS,
    FIELD_FORMATS,
    FIXED_FRAME,
    GEAR_FRAME,
    SCENE_FORMATS,
    UNITS,
    writer_of,
)
from ..status import NotComputed
from .options import MEMBERS, Refusal, no_result

if TYPE_CHECKING:
    from ..arrays import FloatArray
    from ..contact.mesh_position import Frame, MeshingPair
    from ..design.member import Member
    from ..design.model import Design

GEARS, TEETH, FLANKS = (tuple(f"{m}{kind}" for m in MEMBERS) for kind in ("", "-tooth", "-flank"))


@dataclass(frozen=True)
class MeshRequest:
    """Part to be written, with the values of the options.

    Attributes
    ----------
    source : str
        Name of the design or of its file.
    suffix : str
        Format.
    kind : {'surface', 'volume', 'contact', 'solid', 'scene'}
        Kind of geometry.
    bore_radii : tuple of 2 float or None
        Bore radius of pinion and gear, mm.
    placed : bool
        Whether a single part is written in S_f, not in the frame of its gear.

    The other attributes are options of `mesh`: lengths in mm, `load` in N, `torque` in N m.
    """

    source: str
    design: Design
    suffix: str
    kind: str
    part: str
    out: Path
    tolerance: float | None
    flank: str
    teeth: int
    bore_radii: tuple[float | None, float | None]
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
        """0 for a part of the pinion and for the pair, 1 for a part of the gear."""
        return int(self.part in (GEARS[1], TEETH[1], FLANKS[1]))

    @property
    def member(self) -> Member:
        """Gear to which a single part belongs."""
        return self.design.members[self.number]

    @property
    def tooth_count(self) -> int | None:
        """Number of teeth, None for a complete gear."""
        return self.teeth if self.part in TEETH else None

    @property
    def tolerance_mm(self) -> float:
        """Tolerance, mm. The pair in contact and solids need none."""
        assert self.tolerance is not None
        return self.tolerance

    @property
    def needs_contact(self) -> bool:
        """Whether the contact of the flanks is needed."""
        return self.part == "pair" or self.suffix == ".inp" or self.placed or bool(self.fields)

    @property
    def position(self) -> MeshingPair | None:
        """Position of the pair in mesh if it is needed. Raises as `position_of`."""
        return position_of(self.design, self.flank) if self.needs_contact else None

    @property
    def frames(self) -> tuple[Frame, Frame] | None:
        """Frames of the gears in S_f, for the pair and for a part with --placed."""
        if self.part != "pair" and not self.placed:
            return None
        return part_frames(self.design, self.flank, self.roll_deg)

    @property
    def mating_tooth(self) -> int:
        """Index, among the `teeth`, of the tooth that carries the load and is in mesh when placed.

        It is the middle one, or one of the two in the middle such that the remaining teeth of pinion and gear
        mate, too."""
        return (self.teeth - 1 + self.number) // 2 if self.part in TEETH else 0

    @property
    def frame(self) -> Frame | None:
        """Frame in which a single part is written, None for the frame of its gear.

        It is turned back from the position in mesh until the mating tooth is in the place of tooth 0."""
        if self.frames is None or self.part == "pair":
            return None
        rotation, origin = self.frames[self.number]
        angle = 2.0 * math.pi / float(self.member.teeth) * self.mating_tooth
        cosine, sine = math.cos(angle), math.sin(angle)
        return rotation @ [[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]], origin

    @property
    def origin(self) -> FloatArray | None:
        """New origin (3,), mm in S_f, for formats with single precision (.stl, .glb); None if the origin of
        the frame is kept."""
        from ..export.positions import near_origin

        if self.frames is None or self.suffix not in (".stl", ".glb"):
            return None
        origin = near_origin(self.design, position_of(self.design, self.flank))
        return origin if origin.any() else None

    @property
    def each(self) -> list[MeshRequest]:
        """One request for each roll of the pinion. With `rolls`, the files have numbers.

        Raises Refusal if the rolls exceed the path of contact."""
        from ..export.fea.pair_mesh import rolls_in_mesh

        if self.rolls is None:
            return [self]
        position = position_of(self.design, self.flank)
        pitch, middle = 360.0 / float(self.design.pinion.teeth), math.degrees(float(position.roll[0]))
        low, high = map(math.degrees, rolls_in_mesh(position))
        reach = min(high - middle, middle - low) / pitch
        if 0.5 - 0.5 / self.rolls > reach:  # distance of the last roll from the middle, in pitches
            text = f"because tooth pair 0 is in mesh over only {2.0 * reach:.4g} pitches, got {self.rolls}"
            most = int(1.0 / (1.0 - 2.0 * reach))
            raise Refusal([f"--rolls must be at most {most} {text}: or give each roll with --roll-deg"])
        digits = len(str(self.rolls))
        return [
            replace(
                self,
                out=self.out.with_stem(f"{self.out.stem}-{k + 1:0{digits}}"),
                roll_deg=middle + pitch * ((k + 0.5) / self.rolls - 0.5),
            )
            for k in range(self.rolls)
        ]


def position_of(design: Design, flank: str) -> MeshingPair:
    """Return the pair in the middle of its path of contact. Raises NoResult if the flanks have no contact."""
    from ..contact.mesh_position import meshing_pair

    try:
        return meshing_pair(design, flank)
    except ValueError as error:
        from ..contact.path import path_of_contact
        from ..findings.path import reason_of

        reason = reason_of(path_of_contact(design, flank, 3))
        raise no_result(
            reason or str(error), "" if isinstance(reason, NotComputed) else "no contact"
        ) from None
    except ArithmeticError as error:
        raise no_result(NotComputed(error)) from None


def part_frames(design: Design, flank: str, roll_deg: float | None) -> tuple[Frame, Frame]:
    """Return the frames of the gears at a roll, by default in the middle of the path of contact.

    Raises NoResult if there is no contact."""
    from ..export.positions import frames_at_roll
    from ..operation.contact_pattern.motion import UnknownOperationError

    position = position_of(design, flank)
    try:
        return frames_at_roll(design, position, None if roll_deg is None else math.radians(roll_deg))
    except UnknownOperationError as error:
        raise no_result(error.reason, "no contact") from None


def frames_text(design: Design, flank: str, roll_deg: float | None) -> str:
    """Return the matrices (4, 4), in mm, from the frames of the gears to S_f as text."""
    import numpy as np

    lines = []
    for name, (rotation, origin) in zip(MEMBERS, part_frames(design, flank, roll_deg), strict=True):
        lines.append(f"{name}, from its own frame to S_f, mm:")
        rows = np.vstack((np.column_stack((rotation, origin)), (0.0, 0.0, 0.0, 1.0)))
        lines += [" ".join(f"{value:22.15g}" for value in row) for row in rows.tolist()]
    return "\n".join(lines) + "\n"


def begin_writing(request: MeshRequest, bar: Any) -> None:
    """Show in the progress bar that the geometry is complete and is being written."""
    bar.update()
    bar.set_description(f"write {request.out.name}")


def origin_text(request: MeshRequest) -> str:
    """Return the note for the user about a new origin, or an empty text."""
    if request.origin is None:
        return ""
    place = ", ".join(f"{x:z.0f}" for x in request.origin)
    return f"; origin at ({place}) mm in S_f, as single precision loses digits far from it"


def write_surface_part(request: MeshRequest, path: Path, bar: Any) -> str:
    """Build and write a surface; return the message for the user."""
    from ..export import parts
    from ..export.surfaces import in_fixed, moved, write_surface

    suffix, tolerance = request.suffix, request.tolerance_mm
    if request.part in FLANKS:
        surface = parts.flank_part(
            request.design, request.number, request.flank, tolerance, request.position, request.fields
        )
    elif request.part == "pair":
        assert request.frames is not None
        surface = parts.pair_surface(request.design, request.frames, suffix, tolerance, request.bore_radii)
    else:
        bore = request.bore_radii[request.number]
        surface = parts.gear_surface(request.member, suffix, tolerance, request.tooth_count, bore)
    if request.frame is not None:
        surface = in_fixed(surface, request.frame)
    note = origin_text(request)
    if request.origin is not None:
        surface = moved(surface, -request.origin)
    begin_writing(request, bar)
    write_surface(surface, path, suffix, f"{request.part} of {Path(request.source).name}, mm{note}")
    message = f"{len(surface.faces):,} triangles, {len(surface.points):,} points"
    if suffix in FIELD_FORMATS and surface.part_names:
        message += f"; part: {', '.join(f'{k} {name}' for k, name in enumerate(surface.part_names))}"
    return message + note


def write_volume_part(request: MeshRequest, path: Path, bar: Any) -> str:
    """Build and write hexahedra; return the message for the user."""
    not_resolved = "stresses at the contact are not resolved, those of the fillet are"
    cut_sides_held = "held at its cut sides: use --teeth 3 for stresses"
    from ..export import parts
    from ..export.fea.volumes import write_volume
    from ..shapes.hexahedra import tooth_hexahedra
    from ..shapes.hexahedral_mesh import element_shapes, rounded_down
    from ..shapes.tooth_boundary import counted

    member, position = request.member, request.position
    teeth, element, loaded = request.teeth, request.element, request.mating_tooth
    bore = request.bore_radii[request.number]
    mesh = tooth_hexahedra(member, teeth, element, request.tolerance_mm, bore)
    begin_writing(request, bar)
    message = f"{len(mesh.hexahedra):,} hexahedra {element}, {len(mesh.points):,} nodes"
    message += f", scaled Jacobian {rounded_down(element_shapes(mesh)[0].min())} or more"
    edges = f"edges within {request.tolerance_mm:g} mm"
    comment = [f"{request.part} of {request.source}, {counted(teeth)}, {edges}"]
    case = None
    if position is not None and request.suffix == ".inp":
        case = parts.contact_case(mesh, request.design, position, request.number, request.load, loaded)
    if request.frame is not None:
        mesh, case = parts.placed_volume(mesh, case, request.frame)
    if case is not None:
        place = ", ".join(f"{x:z.4f}" for x in case.load.point)
        where = f"{request.load:g} N on the {request.flank} flank of tooth {loaded + 1} of {teeth}"
        where += f" at ({place}) mm"
        comment += [f"{where}, the middle of the path of contact", f"{case.load.description}."]
        comment.append(f"{not_resolved}.")
        message += f"; {where}, {case.load.description}; {not_resolved}"
        if teeth < min(3, member.teeth):
            comment.append(f"The loaded tooth is {cut_sides_held}.")
            message += f"; {cut_sides_held}"
        message += solver_note(len(mesh.points), request.out)
    frame = FIXED_FRAME if request.placed else GEAR_FRAME
    write_volume(mesh, path, element, case=case, comment=comment, suffix=request.suffix, frame=frame)
    return message


def write_contact_part(request: MeshRequest, path: Path, bar: Any) -> str:
    """Build and write the pair in contact; return the message for the user."""
    # Default force between the teeth for a module of 6 mm, N; it scales with the square of the module.
    tooth_force_n = 20e3
    from ..contact.parallel.lines import is_line_contact
    from ..export.fea.pair_mesh import ELEMENT, force_lever, pair_mesh
    from ..report.result import failure_of
    from ..shapes.tooth_boundary import counted

    design, position = request.design, request.position
    assert position is not None  # always given for the pair
    if jammed := failure_of(None, design):
        raise no_result(jammed.text)
    lever, size = force_lever(design), float(design.pinion.tool.normal_module) / 6.0
    torque = 1e-3 * tooth_force_n * size**2 * lever if request.torque is None else request.torque
    force = 1e3 * torque / lever
    pair = pair_mesh(
        design,
        position,
        None if request.roll_deg is None else math.radians(request.roll_deg),
        teeth=request.teeth,
        force=force,
        across=request.across,
        tolerance=request.tolerance,
        bore_radii=request.bore_radii,
    )
    begin_writing(request, bar)
    where = f"{torque:.6g} N m on the pinion at a roll of {math.degrees(pair.roll[0]):z.4f} deg"
    shape = "strip" if is_line_contact(design, request.flank) else "ellipse"
    fine = f"elements: {pair.across:.2g} across and {pair.along:.2g} along the {shape} of {force:.4g} N"
    comment = [f"pair of {request.source}, {counted(request.teeth)} of each", where, fine, FIXED_FRAME, UNITS]
    write = writer_of(CONTACT_FORMATS, request.suffix)
    write(path, design, pair, 1e3 * torque, comment, request.rolls or 1)
    message = f"{len(pair.mesh.hexahedra):,} hexahedra {ELEMENT}, {len(pair.mesh.points):,} nodes"
    message += f"; {where}, {request.flank} flanks; {fine}"
    return message + solver_note(len(pair.mesh.points), request.out)


def solver_note(nodes: int, deck: Path) -> str:
    """Return the command that runs CalculiX, and the memory for a number of nodes if it is large."""
    # Memory of CalculiX in GB, divided by the number of nodes to the power 4/3, measured on pairs of
    # 20,000 to 37,000 nodes.
    gb_per_nodes_to_four_thirds = 9.5e-7
    # Solver memory that is not mentioned.
    small_memory_gb = 1.0
    size = gb_per_nodes_to_four_thirds * nodes ** (4.0 / 3.0)
    memory = f"; CalculiX takes about {size:.2g} GB of memory" if size > small_memory_gb else ""
    return f"{memory}; run: {ccx_command(deck)}"


def ccx_command(deck: Path) -> str:
    """Return the command line by which CalculiX solves a deck.

    CalculiX takes the name without `.inp`, appends it in lower case, and writes into the current folder."""
    command = f"ccx -i {shlex.quote(deck.stem)}"
    if deck.suffix != ".inp":
        command = f"mv {shlex.quote(deck.name)} {shlex.quote(deck.stem + '.inp')} && {command}"
    return command if deck.parent == Path() else f"cd {shlex.quote(str(deck.parent))} && {command}"


def write_solid_part(request: MeshRequest, path: Path, _: Any) -> str:
    """Build and write a solid; return the message for the user."""
    from ..shapes.tooth_boundary import counted

    member = request.member
    if request.part == "pair":
        write_pair = writer_of(ASSEMBLY_FORMATS, request.suffix)
        write_pair(request.design, path, request.frames, request.bore_radii)
        return f"an assembly of {' and '.join(MEMBERS)}"
    numbers = None if request.tooth_count is None else range(request.tooth_count)
    write, bore = writer_of(CAD_FORMATS, request.suffix), request.bore_radii[request.number]
    write(member, path, numbers, bore, MEMBERS[request.number], request.frame)
    return f"a solid with {counted(int(member.teeth) if numbers is None else len(numbers))}"


def write_scene_part(request: MeshRequest, path: Path, bar: Any) -> str:
    """Build and write the pair for viewers, with paths and patterns; return the message for the user."""
    from ..export.scene import pair_scene
    from ..export.surfaces import moved

    position, frames = request.position, request.frames
    assert position is not None
    assert frames is not None  # always given for the pair
    items = pair_scene(request.design, position, frames, request.tolerance_mm, request.bore_radii)
    if request.origin is not None:
        items = [replace(item, surface=moved(item.surface, -request.origin)) for item in items]
    begin_writing(request, bar)
    writer_of(SCENE_FORMATS, request.suffix)(items, path)
    faces = sum(len(item.surface.faces) for item in items)
    names = ", ".join(item.name for item in items)
    note = "" if "pattern" in names else "; no pattern, because all points are beyond its separation"
    return f"{faces:,} triangles in m, y up: {names}{note}{origin_text(request)}"


WRITERS = {
    "surface": write_surface_part,
    "volume": write_volume_part,
    "contact": write_contact_part,
    "solid": write_solid_part,
    "scene": write_scene_part,
}
"""Function for each kind of request."""
