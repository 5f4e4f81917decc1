"""Data of the 3D view of the pair in mesh, as JSON: teeth, frames, paths, and contacts.

One tooth of each member is stored in the frame of the member; the page rotates copies. Tooth pair k is tooth
k of the pinion and tooth -k of the gear. All tooth pairs have the same path in the fixed frame S_f (z along
the pinion axis). At the pinion roll r, pair k is at the point of this path where pair 0 is at the roll r + k
times the angular pitch.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebfit, chebpts1
from numpy.typing import NDArray

from beveloid_geom import ContactPath, Design, Member, MeshCycle, Status, mesh_cycle, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import Frame, frames_at
from beveloid_geom.design.arguments import require_single
from beveloid_geom.design.ends import end_names, limit_words
from beveloid_geom.findings.path import reason_of
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.operation.cycle.cycle_segments import SEGMENT_DEGREE
from beveloid_geom.operation.engagement import conjugate_phase, pitch_point_roll
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.shapes.section import SIDES
from beveloid_geom.shapes.surface_mesh import TriangleMesh, gear_mesh
from beveloid_geom.status import FirstStatus

from ..components.paths_table import FLANKS, MEMBERS, points_on
from ..rendering.polylines import simplified


def view_data(design: Design, tolerance: float | None = None) -> dict[str, Any]:
    """Return the data of the view for a single design, ready for `json.dumps`, in mm and rad, without NaN.

    Parameters
    ----------
    design : Design
        A single design.
    tolerance : float, optional
        Largest deviation of the triangles, mm; by default in proportion to the module.

    Returns
    -------
    dict
        `members`: pinion and gear with frame at roll 0 in S_f and tooth, or the reason. `flanks`: right and
        left with the path of tooth pair 0 and one mesh `cycle`, or the reason. `module`: normal module, mm.
        `roll`: pinion roll at which the view starts, rad. `mesh_point`: centre of the view in S_f, mm.

    Raises
    ------
    ValueError
        For a batch of designs.
    """
    require_single(design)
    frames = frames_at(design, 0.0, 0.0)
    members = [
        _member(name, member, tolerance) | place
        for name, member, place in zip(MEMBERS, design.members, member_frames(design), strict=True)
    ]
    flanks = {flank: flank_data(design, flank) for flank in FLANKS}
    return {
        "module": float(design.pinion.tool.normal_module),
        "members": members,
        "flanks": flanks,
        "roll": next((flank for flank in flanks.values() if flank["path"]), flanks["right"])["middle"],
        "mesh_point": _mesh_point(design, frames).tolist(),
    }


def packed(values: NDArray[Any]) -> dict[str, Any]:
    """Return an array for the page: bytes, little-endian, in base64."""
    array = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return {"type": values.dtype.name, "data": base64.b64encode(array.tobytes()).decode()}


def member_frames(design: Design) -> list[dict[str, Any]]:
    """Return rotation and origin (mm) of pinion and gear at roll 0 in S_f."""
    frames = [[np.nan_to_num(part) for part in frame] for frame in frames_at(design, 0.0, 0.0)]
    return [{"rotation": turn.ravel().tolist(), "origin": origin.tolist()} for turn, origin in frames]


def _member(name: str, member: Member, tolerance: float | None) -> dict[str, Any]:
    """Return sizes and tooth of a member."""
    # A fifth of a pixel at the closest view, ten modules on a thousand pixels.
    tolerance_modules = 1.0 / 500.0
    half, module = 0.5 * float(member.face_width), float(member.tool.normal_module)
    tooth, note = None, ""
    try:
        mesh = gear_mesh(member, tolerance_modules * module if tolerance is None else tolerance, (0,))
        tooth = _tooth(mesh.where(~mesh.is_of(*SIDES)))
    except ValueError as error:
        note = f"The {name} is drawn without teeth: {error}."
    return {
        "name": name,
        "ends": list(end_names(member)),
        "teeth": int(member.teeth),
        "half_width": half,
        "tip_radius": [float(tip_radius(member, z)) for z in (-half, half)],
        "tooth": tooth,
        "note": note,
    }


def _tooth(mesh: TriangleMesh) -> dict[str, Any]:
    """Return the triangles of a tooth, end faces last, and the corners of its flanks."""
    ends = mesh.is_of("toe", "heel")
    faces = np.concatenate((mesh.faces[~ends], mesh.faces[ends]))
    corners = {flank: _corners(mesh.of(f"{flank} flank").points).tolist() for flank in FLANKS}
    return {
        "points": packed(mesh.points.astype(np.float32)),
        "normals": packed(mesh.normals.astype(np.float32)),
        "faces": packed(faces.astype(np.uint16 if len(mesh.points) < 1 << 16 else np.uint32)),
        "end_faces": int(ends.sum()),
        "corners": corners,
    }


def _corners(points: FloatArray) -> FloatArray:
    """Return root and tip at -z and root and tip at +z, (4, 3)."""
    radius, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    corners = []
    for end in (z.min(), z.max()):
        there = np.flatnonzero(np.abs(z - end) < 1e-9 * np.ptp(z))
        corners += [points[there[radius[there].argmin()]], points[there[radius[there].argmax()]]]
    return np.array(corners)


def flank_data(
    design: Design, flank: str, mesh: MeshCycle | None = None, tolerance: float = 0.0
) -> dict[str, Any]:
    """Return the path of contact of tooth pair 0 and one mesh cycle, as data of the view.

    `mesh`: the mesh cycle, if it has been computed already. `tolerance`: largest deviation, mm, of the lines
    on the teeth from the path; with 0 they have all points of the path. Keys of the result: `path` (None if
    there is none), `middle` (pinion roll at the middle of the path, rad), `lever` (mm per rad of gear
    rotation), `note` (reason for a missing path), `cycle`."""
    path_points = 65
    path = path_of_contact(design, flank, path_points)
    solved = path.status == Status.SOLVED
    cycle = _cycle(design, flank, path, mesh)
    middle = cycle["start"] + 0.5 * cycle["pitch"] * (cycle["by"] != "first contact")
    data: dict[str, Any] = {"path": None, "middle": middle, "lever": 0.0, "note": "", "cycle": cycle}
    if solved.sum() < 2:
        reason = reason_of(path) or f"the {flank} flanks have no path of contact"
        return data | {"note": f"{reason[0].upper()}{reason[1:]}."}
    shown = {
        "roll": path.pinion_roll,
        "phase": _phase(design, path.pinion_roll, path.gear_roll),
        "point": path.point,
        "normal": path.normal,
        "pinion": points_on(path, 0),
        "gear": points_on(path, 1),
    }
    data["middle"] = float(path.pinion_roll[solved][solved.sum() // 2])
    packed_path = {name: packed(values[solved]) for name, values in shown.items()}
    if tolerance > 0.0:
        packed_path |= {name: packed(simplified(shown[name][solved], tolerance)) for name in MEMBERS}
    return data | {"lever": _lever(path), "path": packed_path}


def _phase(design: Design, pinion_roll: FloatArray, gear_roll: FloatArray) -> FloatArray:
    """Return gear roll plus N1/N2 pinion roll, rad: constant for a constant ratio, equal for all tooth
    pairs."""
    return np.asarray(gear_roll + float(design.pinion.teeth) / float(design.gear.teeth) * pinion_roll)


def _mesh_point(design: Design, frames: tuple[Frame, Frame]) -> FloatArray:
    """Return the point (3,) in S_f, mm, at the centre of the view: the pitch point, or a point of the pinion
    on the side of the gear."""
    pitch_point, tip = mounting_of(design).pitch_point, float(tip_radius(design.pinion, 0.0))
    if np.hypot(*pitch_point[:2]) < 1.5 * tip:
        return np.asarray(pitch_point)
    return np.asarray(np.nan_to_num(frames[0][1]) + np.array([tip, 0.0, 0.0]))


def _lever(path: ContactPath) -> float:
    """Return the moment of the normal about the gear axis in the middle of the path: gap in mm per rad."""
    rotation, origin = frames_at(path.design, 0.0, 0.0)[1]
    middle = len(path.point) // 2
    moment = np.cross(path.point[middle] - origin, path.normal[middle]) @ rotation[:, 2]
    return float(abs(np.nan_to_num(moment)))


def _cycle(design: Design, flank: str, path: ContactPath, cycle: MeshCycle | None) -> dict[str, Any]:
    """Return the contacts over one pitch, in segments.

    The segments end at `ends` after `start`. `phase` gives the position of the gear, and for edge contact
    `point` gives the contact in S_f with the names of the edges; both are Chebyshev coefficients on -1 to 1.
    The gear is positioned by the first contact of all teeth, with edges and fillets. If this is unknown, the
    gear is positioned by the path of the tooth pair that turns it furthest, or as without modification; `by`
    names the case.
    """
    # Number of segments of a cycle if the gear is not positioned by first contacts.
    cycle_steps = 120
    pitch, start = 2.0 * np.pi / float(design.pinion.teeth), 0.0
    try:
        start = float(np.nan_to_num(pitch_point_roll(design, flank)))
        cycle = mesh_cycle(design, flank) if cycle is None else cycle
    except ValueError:
        pass  # the rounds of the tool overlap, so that there are no fillets
    if cycle is not None and cycle.status == FirstStatus.SOLVED:
        data = {"start": start, "pitch": pitch, "ends": packed(cycle.segments.high - start)}
        return data | {"phase": packed(cycle.phase_series()), "edges": _edges(cycle), "by": "first contact"}
    start -= 0.5 * pitch
    steps = pitch * np.linspace(0.0, 1.0, cycle_steps + 1)
    by, phase = "path", carried_phase(path, start + steps)
    if not np.isfinite(phase).any():
        by, phase = "unmodified", np.full(steps.shape, np.nan_to_num(float(conjugate_phase(design, flank))))
    known = np.isfinite(phase)
    phase = np.interp(start + steps, start + steps[known], phase[known], period=pitch)
    lines = 0.5 * np.stack((phase[1:] + phase[:-1], np.diff(phase)), axis=1)
    data = {"start": start, "pitch": pitch, "ends": packed(steps[1:]), "phase": packed(lines)}
    return data | {"edges": [None] * cycle_steps, "by": by}


def _edges(cycle: MeshCycle) -> list[dict[str, Any] | None]:
    """Return the edges in contact and the coordinates of their contact for each segment; None for flanks and
    lines of contact."""
    edges: list[dict[str, Any] | None] = []
    nodes = chebpts1(SEGMENT_DEGREE + 1)
    for roll, limit in zip(cycle.segments.rolls(nodes), cycle.segments.limit.T, strict=True):
        names = [limit_words(cycle.design, int(code)) for code in limit if code >= 0]
        if not names or cycle.along_lines:
            edges.append(None)
            continue
        point = chebfit(nodes, cycle.at(roll).point, SEGMENT_DEGREE).T
        edges.append({"point": packed(point), "edge": " and ".join(names)})
    return edges


def carried_phase(path: ContactPath, roll: FloatArray) -> FloatArray:
    """Return the phase, rad, at pinion rolls (n,) from the path of contact alone.

    Phase: gear roll plus N1/N2 times the pinion roll, with the numbers of teeth N1 and N2. The result is the
    phase of the tooth pair that turns the gear furthest: lowest on right, highest on left flanks.
    NaN where no tooth pair is on its path.
    """
    design, good = path.design, path.status == Status.SOLVED
    if good.sum() < 2:
        return np.full(roll.shape, np.nan)
    rolls, phases = path.pinion_roll[good], _phase(design, path.pinion_roll, path.gear_roll)[good]
    sign, pitch = 1.0 if path.flank == "left" else -1.0, 2.0 * np.pi / float(design.pinion.teeth)
    low, high = (rolls.min() - roll.max()) / pitch, (rolls.max() - roll.min()) / pitch
    pairs = np.arange(np.floor(low), np.ceil(high) + 1.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (roll[:, None, None] + pairs[:, None] * pitch - rolls[:-1]) / np.diff(rolls)
        candidates = sign * (phases[:-1] + share * np.diff(phases))
    best = np.where((share >= 0.0) & (share <= 1.0), candidates, -np.inf).max(axis=(1, 2))
    return np.where(np.isfinite(best), sign * best, np.nan)
