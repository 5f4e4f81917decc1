"""Faces of a gear for CAD: B-splines of flanks and fillets, cones and cylinders.

A solid is bounded by its end planes and by strips from toe to heel, which follow each other around closed
loops. Flanks and fillets are B-spline surfaces of degree 7 through exact points. Their distance from the
exact surfaces is measured, and knots are added until it is within 1e-6 mm. Tip lands, bottom lands and bore
are surfaces of revolution. Along the face all B-splines have the same knots and the parameter z, so that a
strip and its neighbour have the same line, a `StripEdge`, as their common edge. Poles are the control points
of B-splines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, pi, tan
from typing import Any, TypeAlias

import numpy as np

from ..arrays import FloatArray
from ..contact.mesh_position import Frame
from ..design.member import Member
from ..design.written_numbers import shown_value
from ..gear.fillet import bottom_point, root_radius
from ..gear.flank import turned
from ..gear.flank_limits import tip_radius
from ..gear.tooth_side import fillet_points
from ..gear.undercut import require_flanks
from ..shapes.sampling import flank_sheet
from ..shapes.tooth_body import bore_of
from ..shapes.tooth_boundary import fillet_end_angle
from .seams import face_breaks, seams_of, section_breaks
from .spline_fit import DEGREE, Break, fitted_knots, nodes_of, poles_of

Place: TypeAlias = Callable[[Any, FloatArray], FloatArray]
"""Points (..., 3), mm, of a surface at the parameters s along the section and t along the face, both 0 ...
1."""

PROBES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Knots are chosen for one parameter. The distance is measured at these values of the other parameter."""
STRAIGHT = np.array([0.0, 0.0, 1.0, 1.0])
"""Knots of a straight line between two poles."""


@dataclass(frozen=True, eq=False)
class StripEdge:
    """Line from toe to heel as a clamped B-spline over 0 ... 1, with z linear in the parameter.

    `knots` (k,); `points` (n, 3), mm: poles of the line; `angle` (n,), rad: poles of its angle about the gear
    axis, without jumps. The degree is k - n - 1."""

    knots: FloatArray
    points: FloatArray
    angle: FloatArray


@dataclass(frozen=True, eq=False)
class Net:
    """Clamped B-spline surface over 0 ... 1 along the transverse section and from toe to heel.

    `knots` along the section; `poles` (ns, nz, 3), mm. The outer rows of poles are those of the two edges
    from toe to heel (`StripEdge`)."""

    knots: FloatArray
    poles: FloatArray


@dataclass(frozen=True)
class Revolved:
    """Cone or cylinder about the gear axis: radius (mm) at z = 0, and its increase with z."""

    radius: float
    growth: float


@dataclass(frozen=True, eq=False)
class Strip:
    """Face of the solid from toe to heel between two edges, `first` and `last`.

    Seen from +z, the metal is to the left of the direction from the first to the last edge. `tooth` is the
    number of its tooth, if it has one, counted from 1 at angle 0."""

    name: str
    first: StripEdge
    last: StripEdge
    surface: Net | Revolved
    tooth: int | None = None


@dataclass(frozen=True, eq=False)
class _ToothStrips:
    """Strips of tooth 0 from the left to the right fillet, and its surroundings.

    `root` is the root cone, `middle` the edge in the middle of the following tooth space, and `has_land` is
    whether there is a bottom land."""

    strips: list[Strip]
    root: Revolved
    middle: StripEdge
    has_land: bool


@dataclass(frozen=True, eq=False)
class SolidPart:
    """Solid to be written.

    `name`; closed `loops` of strips that bound it, the outer one first; `frame` in an assembly, None for a
    single product."""

    name: str
    loops: Sequence[Sequence[Strip]]
    frame: Frame | None = None


def gear_loops(
    member: Member, tooth_numbers: Sequence[int] | None = None, bore_radius: float | None = None
) -> list[list[Strip]]:
    """Return the faces of a gear between toe and heel as closed loops.

    Parameters
    ----------
    member : Member
        A single member.
    tooth_numbers : sequence of int, optional
        Neighbouring teeth; tooth 0 is at angle 0. All teeth by default. A part of a gear is cut in the middle
        of the tooth spaces next to it, radially down to the bore.
    bore_radius : float, optional
        mm; see `bore_of` for the default.

    Returns
    -------
    list of list of Strip
        Outline and bore of a complete gear, or one loop around the teeth.

    Raises
    ------
    ValueError
        For a flank that undercut removes, a pointed tooth, a pointed tool, a bore outside its limits, teeth
        that are not neighbours, and a tooth that winds around the complete gear.
    """
    numbers = _numbers_of(member, tooth_numbers)
    require_flanks(member)
    cut, bore, pitch = _cut_tooth(member), bore_of(member, bore_radius), 2.0 * pi / float(member.teeth)
    space = Strip("bottom", cut.strips[-1].last, _turned(cut.strips[0].first, pitch), cut.root)
    tooth = [*cut.strips, space] if cut.has_land else cut.strips
    total = int(member.teeth)
    outline = [
        _turned_strip(strip, number * pitch, number % total + 1) for number in numbers for strip in tooth
    ]
    if len(numbers) == total:
        loops = [outline, _complete_bore(member, bore)]
    else:
        loops = [_sector(cut, outline, numbers, total, bore)]
    for strip in (strip for loop in loops for strip in loop if isinstance(strip.surface, Revolved)):
        if np.ptp(np.concatenate((strip.first.angle, strip.last.angle))) > 0.999 * 2.0 * pi:
            text = (
                f"face_width {float(member.face_width):g} mm: the {strip.name} winds around the complete gear"
            )
            raise ValueError(f"{text}: use a narrower face or a smaller helix angle")
    return loops


def _numbers_of(member: Member, given: Sequence[int] | None) -> list[int]:
    """Return the numbers of the teeth, all by default. Raises ValueError unless they are neighbours."""
    total = int(member.teeth)
    numbers = list(range(total)) if given is None else [int(number) for number in given]
    if not 0 < len(numbers) <= total or np.any(np.diff(numbers) != 1):
        text = f"tooth_numbers must be 1 to {total} successive numbers, got {shown_value(numbers)}"
        raise ValueError(f"{text}: give neighbouring teeth in increasing order, such as 0, 1, 2")
    return numbers


def _flank_place(member: Member, flank: str) -> Place:
    """Return the exact flank; s runs from its joint with the fillet to its tip. Seams have constant s."""
    from scipy.interpolate import make_interp_spline

    sheet, seams = flank_sheet(member, flank, to_fillet=True), seams_of(member, flank)
    shares = np.array([0.0, *(one.place for one in section_breaks(member, flank)), 1.0])
    # Between seams l is linear in s, or where derivatives have to be continuous across seams, a spline.
    smooth = max((seam.continuous for seam in seams), default=0) > 0
    blend = make_interp_spline(
        shares, np.eye(shares.size), 3 if smooth else 1, bc_type="natural" if smooth else None
    )

    def place(s: Any, t: FloatArray) -> FloatArray:
        """Return points of the flank."""
        z, s = sheet.half_width * (2.0 * t - 1.0), s if flank == "left" else 1.0 - s
        ends = np.broadcast_arrays(sheet.lower(z), *(seam.at(z) for seam in seams), sheet.upper(z))
        l = (blend(s) * np.stack(ends, axis=-1)).sum(axis=-1)
        return sheet.place(l, np.broadcast_to(z, l.shape))[0]

    return place


def _fillet_place(member: Member, flank: str) -> Place:
    """Return the exact fillet; s is linear in log(tan(angle / 2)).

    Sine and cotangent of the angle are smoother functions of this parameter than of the angle itself."""
    half = 0.5 * float(member.face_width)

    def place(s: Any, t: FloatArray) -> FloatArray:
        """Return points (..., 3), mm, at parameters s across and t along the fillet."""
        z, s = half * (2.0 * t - 1.0), s if flank == "left" else 1.0 - s
        end = fillet_end_angle(member, flank, z)
        angle = 2.0 * np.arctan(np.exp(s * np.log(np.tan(0.5 * end))))
        return fillet_points(member, flank, angle, z)[0]

    return place


def _places(member: Member) -> dict[str, Place]:
    """Return fillets and flanks of tooth 0 from left to right, with s in the same direction."""
    return {
        "left fillet": _fillet_place(member, "left"),
        "left flank": _flank_place(member, "left"),
        "right flank": _flank_place(member, "right"),
        "right fillet": _fillet_place(member, "right"),
    }


def _strip_edge(knots: FloatArray, points: FloatArray) -> StripEdge:
    """Return the line through points (n, 3) at the nodes of its knots."""
    angle = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    angle -= 2.0 * pi * np.round(np.median(angle) / (2.0 * pi))
    poles = poles_of(knots, points)
    # z is exactly linear, so that the ends are in planes: Greville's nodes are the poles of t.
    poles[:, 2] = points[0, 2] + (points[-1, 2] - points[0, 2]) * nodes_of(knots)
    return StripEdge(knots, poles, poles_of(knots, angle))


def _net(place: Place, first: StripEdge, last: StripEdge, breaks: Sequence[Break] = ()) -> Net:
    """Return the surface between two edges; its outer rows of poles are those of the edges.

    Derivatives may jump at the `breaks` across the section."""
    # Largest distance of flanks and fillets from the exact surfaces along the section.
    fit_tolerance_mm = 1e-6
    across = fitted_knots(lambda s: place(s[:, None], PROBES), fit_tolerance_mm, breaks)
    t = nodes_of(first.knots)
    poles = poles_of(first.knots, poles_of(across, place(nodes_of(across)[:, None], t)), axis=1)
    poles[0], poles[-1] = first.points, last.points
    poles[..., 2] = first.points[:, 2]
    return Net(across, poles)


def _cut_tooth(member: Member) -> _ToothStrips:
    """Fit tooth 0 by B-splines. Raises ValueError for a pointed tooth."""
    # Largest distance along the face, where lines of B-splines are on cones. The CAD kernel identifies
    # points within 1e-7 mm.
    edge_fit_mm = 1e-8
    # Width below which a bottom land is omitted and a tooth counts as pointed.
    narrow_land_mm = 1e-5
    places, pitch = _places(member), 2.0 * pi / float(member.teeth)
    lines = [(place, s) for place in places.values() for s in PROBES]
    knots = fitted_knots(
        lambda t: np.stack([place(s, t) for place, s in lines], axis=1), edge_fit_mm, face_breaks(member)
    )
    t, taper = nodes_of(knots), tan(float(member.cone_angle))
    tip, root = (Revolved(float(radius(member, 0.0)), taper) for radius in (tip_radius, root_radius))
    starts, ends = ([_strip_edge(knots, place(s, t)) for place in places.values()] for s in (0.0, 1.0))
    left_root, left_tip, right_tip, right_root = starts[0], ends[1], starts[2], ends[3]
    if np.any((right_tip.angle - left_tip.angle) * tip.radius < narrow_land_mm):
        raise ValueError("the tooth tip is pointed: reduce addendum, profile shift or face width")
    has_land = bool(np.all((left_root.angle + pitch - right_root.angle) * root.radius > narrow_land_mm))
    if not has_land:
        right_root = _turned(left_root, pitch)
    pairs = (left_root, starts[1]), (starts[1], left_tip), (right_tip, starts[3]), (starts[3], right_root)
    left = section_breaks(member, "left")
    right = [Break(1.0 - one.place, one.continuous) for one in reversed(section_breaks(member, "right"))]
    strips = [
        Strip(name, *pair, _net(place, *pair, breaks))
        for (name, place), pair, breaks in zip(places.items(), pairs, ((), left, right, ()), strict=True)
    ]
    strips.insert(2, Strip("tip", left_tip, right_tip, tip))
    return _ToothStrips(strips, root, _middle(member, knots) if has_land else right_root, has_land)


def _middle(member: Member, knots: FloatArray) -> StripEdge:
    """Return the middle of the tooth space after tooth 0 on the bottom land."""
    z = 0.5 * float(member.face_width) * (2.0 * nodes_of(knots) - 1.0)
    return _strip_edge(
        knots, bottom_point(member, "right", 0.5 * pi * float(member.tool.normal_module), z)[0]
    )


def _turned(edge: StripEdge, angle: float) -> StripEdge:
    """Return an edge that is turned about the gear axis."""
    return StripEdge(edge.knots, turned(angle, *np.moveaxis(edge.points, -1, 0)), edge.angle + angle)


def _turned_strip(strip: Strip, angle: float, tooth: int) -> Strip:
    surface = strip.surface
    if isinstance(surface, Net):
        surface = Net(surface.knots, turned(angle, *np.moveaxis(surface.poles, -1, 0)))
    return Strip(strip.name, _turned(strip.first, angle), _turned(strip.last, angle), surface, tooth)


def _complete_bore(member: Member, radius: float) -> list[Strip]:
    """Return the bore of a complete gear as two halves, in clockwise order."""
    half = 0.5 * float(member.face_width)
    line = StripEdge(STRAIGHT, np.array([[radius, 0.0, -half], [radius, 0.0, half]]), np.zeros(2))
    edges = [_turned(line, -pi * i) for i in range(3)]
    return [Strip("bore", *pair, Revolved(radius, 0.0)) for pair in pairwise(edges)]


def _sector(
    cut: _ToothStrips, outline: list[Strip], numbers: list[int], total: int, bore: float
) -> list[Strip]:
    """Return the loop around some teeth whose strips, with the spaces after them, are `outline`."""
    pitch = 2.0 * pi / total
    start, end = (_turned(cut.middle, number * pitch) for number in (numbers[0] - 1, numbers[-1]))
    loop = list(outline)
    if cut.has_land:
        loop.insert(0, Strip("bottom", start, outline[0].first, cut.root, (numbers[0] - 1) % total + 1))
        loop[-1] = replace(outline[-1], last=end)
    inner = _on_cylinder(start, bore)
    width = len(numbers) * pitch
    pieces = ceil((width + float(np.ptp(start.angle))) / pi)
    rim = [_turned(inner, width * (1.0 - i / pieces)) for i in range(pieces + 1)]
    loop.append(Strip("last side", end, rim[0], _ruled(end, rim[0])))
    loop += [Strip("bore", *pair, Revolved(bore, 0.0)) for pair in pairwise(rim)]
    loop.append(Strip("first side", inner, start, _ruled(inner, start)))
    return loop


def _ruled(first: StripEdge, last: StripEdge) -> Net:
    """Return the ruled surface between two edges."""
    return Net(STRAIGHT, np.stack((first.points, last.points)))


def _on_cylinder(edge: StripEdge, radius: float) -> StripEdge:
    """Return the edge with the same angles on a cylinder."""
    from scipy.interpolate import BSpline

    angle = BSpline(edge.knots, edge.angle, DEGREE)(nodes_of(edge.knots))
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle), edge.points[:, 2]), axis=-1)
    inner = _strip_edge(edge.knots, points)
    return StripEdge(inner.knots, inner.points, edge.angle)
