"""The faces of a gear for CAD: B-splines over flanks and fillets, cones and cylinders.

A solid is bounded by its end planes and by strips from toe to heel that follow each other round
closed loops. Flanks and fillets are B-spline surfaces of degree 7 through exact points, within
`FIT` of the exact surfaces, as is measured while they are made. Tip lands, bottom lands and
bore are surfaces of revolution. Over the face all B-splines have the same knots and z for
their parameter: a strip and its neighbour have the same line, a `Trace`, for their edge.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, pi, tan
from typing import Any, TypeAlias

import numpy as np

from ..arrays import FloatArray
from ..contact.placing import Frame
from ..design.field_limits import shown_value
from ..design.model import Member
from ..gear.fillet import bottom_point, fillet_point, root_radius, tool_round
from ..gear.flank import tip_radius, turned
from ..gear.undercut import require_sound
from ..shapes.sampling import flank_sheet
from ..shapes.solid import bore_of

Place: TypeAlias = Callable[[Any, FloatArray], FloatArray]
"""Points (..., 3), mm, of a surface at its stations s, along the section, and t, both 0 ... 1."""

DEGREE = 7
FIT = 1e-6
"""mm. How close flanks and fillets are to the exact surfaces along the section."""
FIT_OF_TRACES = 1e-8
"""mm. The same along the face, where lines of B-splines lie on cones: the kernel takes two points for
one up to 1e-7 mm."""
SPANS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)
PROBES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Where a surface is looked at across the direction in which its knots are sought."""
NARROW = 1e-5
"""mm. A bottom land narrower than this is left out, a tip land counts as pointed."""
STRAIGHT = np.array([0.0, 0.0, 1.0, 1.0])
"""Knots of a straight line."""


@dataclass(frozen=True, eq=False)
class Trace:
    """A line from toe to heel as a clamped B-spline over 0 ... 1, along which z grows evenly:
    `knots` (k,), poles `points` (n, 3), mm, and poles of its `angle` (n,) about the gear axis,
    rad, without jumps. The degree is k - n - 1."""

    knots: FloatArray
    points: FloatArray
    angle: FloatArray


@dataclass(frozen=True, eq=False)
class Net:
    """A clamped B-spline surface over 0 ... 1 along the section and from toe to heel: `knots`
    along the section, `poles` (ns, nz, 3), mm, whose outer rows are those of its traces."""

    knots: FloatArray
    poles: FloatArray


@dataclass(frozen=True)
class Revolved:
    """A cone or cylinder about the gear axis: radius (mm) at z = 0 and its growth with z."""

    radius: float
    growth: float


@dataclass(frozen=True, eq=False)
class Strip:
    """A face of the solid from toe to heel between two traces, the metal on the left of the way
    from the first to the last, seen from +z. `tooth`: the number of its tooth, if it has one, from 1 at
    angle 0 on."""

    name: str
    first: Trace
    last: Trace
    surface: Net | Revolved
    tooth: int | None = None


@dataclass(frozen=True, eq=False)
class _Tooth:
    """The strips of tooth 0 from the left to the right fillet, the root cone, the trace at the
    `middle` of the tooth space after it, and whether there is any bottom land."""

    strips: list[Strip]
    root: Revolved
    middle: Trace
    has_land: bool


@dataclass(frozen=True, eq=False)
class Part:
    """A solid to be written: its `name`, the closed `loops` of strips that bound it, the outer one first,
    and the `frame` that carries it to that of an assembly, None for a product by itself."""

    name: str
    loops: Sequence[Sequence[Strip]]
    frame: Frame | None = None


def gear_loops(
    member: Member, tooth_numbers: Sequence[int] | None = None, bore_radius: float | None = None
) -> list[list[Strip]]:
    """Make the faces of a gear between toe and heel, as closed loops: outline and bore of a whole gear, or
    the one loop round the neighbouring teeth of some `tooth_numbers` (0 is at angle 0). Part of a gear is
    cut in the middle of the tooth spaces beside it, radially down to the `bore_radius` (mm).

    Raises ValueError for an undercut member, a pointed tooth, a pointed tool, a bore out of
    its limits, teeth that are no neighbours and a tooth that winds round the gear."""
    numbers = _numbers_of(member, tooth_numbers)
    require_sound(member)
    cut, bore, pitch = _cut_tooth(member), bore_of(member, bore_radius), 2.0 * pi / float(member.teeth)
    space = Strip("bottom", cut.strips[-1].last, _turned(cut.strips[0].first, pitch), cut.root)
    one = [*cut.strips, space] if cut.has_land else cut.strips
    total = int(member.teeth)
    outline = [
        _turned_strip(strip, number * pitch, number % total + 1) for number in numbers for strip in one
    ]
    if len(numbers) == total:
        loops = [outline, _whole_bore(member, bore)]
    else:
        loops = [_sector(cut, outline, numbers, total, bore)]
    for strip in (strip for loop in loops for strip in loop if isinstance(strip.surface, Revolved)):
        if np.ptp(np.concatenate((strip.first.angle, strip.last.angle))) > 0.999 * 2.0 * pi:
            text = f"face_width {float(member.face_width):g} mm: the {strip.name} winds round the whole gear"
            raise ValueError(f"{text}: take a narrower face or a smaller helix angle")
    return loops


def _numbers_of(member: Member, given: Sequence[int] | None) -> list[int]:
    """List the teeth, all of them unless `given`. Raises ValueError unless they are neighbours."""
    total = int(member.teeth)
    numbers = list(range(total)) if given is None else [int(number) for number in given]
    if not 0 < len(numbers) <= total or np.any(np.diff(numbers) != 1):
        text = f"tooth_numbers must be 1 to {total} neighbours in rising order, got {shown_value(numbers)}"
        raise ValueError(f"{text}: number them as in 0, 1, 2")
    return numbers


def _knots(spans: int) -> FloatArray:
    return np.concatenate((np.zeros(DEGREE), np.linspace(0.0, 1.0, spans + 1), np.ones(DEGREE)))


def _nodes(knots: FloatArray) -> FloatArray:
    """Find the points at which a B-spline is made to agree: Greville's, the means of `DEGREE` knots."""
    return np.asarray(np.lib.stride_tricks.sliding_window_view(knots[1:-1], DEGREE).mean(axis=-1))


def _poles(knots: FloatArray, values: FloatArray, axis: int = 0) -> FloatArray:
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(_nodes(knots), values, DEGREE, knots, axis=axis)
    return np.asarray(np.moveaxis(spline.c, 0, axis))


def _fitted_knots(values: Callable[[FloatArray], FloatArray], fit: float) -> FloatArray:
    """Give the shortest knots for which B-splines through `values` (n, ...) keep to them within `fit`."""
    from scipy.interpolate import BSpline

    for spans in SPANS:
        knots = _knots(spans)
        nodes = _nodes(knots)
        between = (nodes[:-1] + np.diff(nodes) * np.array([[0.25], [0.5], [0.75]])).ravel()
        spline = BSpline(knots, _poles(knots, values(nodes)), DEGREE)
        if np.abs(spline(between) - values(between)).max() < fit:
            return knots
    text = f"no B-spline of {SPANS[-1]} spans comes within {fit:g} mm of the tooth"
    raise ValueError(f"{text}: take a narrower face, a weaker parabola or a smaller helix angle")


def _flank_place(member: Member, flank: str) -> Place:
    """Find the exact flank from its joint with the fillet to its tip."""
    sheet = flank_sheet(member, flank, tool_round(member.tool, flank).joint)

    def place(s: Any, t: FloatArray) -> FloatArray:
        z, s = sheet.half_width * (2.0 * t - 1.0), s if flank == "left" else 1.0 - s
        low = sheet.lower(z)
        return sheet.place(low + s * (sheet.upper(z) - low), z)[0]

    return place


def _fillet_place(member: Member, flank: str) -> Place:
    """Give the exact fillet; s is even in log(tan(angle / 2)), of which sine and cotangent of the
    angle are smoother functions than of the angle itself."""
    half, joint = 0.5 * float(member.face_width), tool_round(member.tool, flank).angle

    def place(s: Any, t: FloatArray) -> FloatArray:
        s = s if flank == "left" else 1.0 - s
        angle = 2.0 * np.arctan(np.exp(s * np.log(np.tan(0.5 * joint))))
        return fillet_point(member, flank, angle, half * (2.0 * t - 1.0))[0]

    return place


def _places(member: Member) -> dict[str, Place]:
    """Find fillets and flanks of tooth 0 in the order of its section, s and they from left to right."""
    return {
        "left fillet": _fillet_place(member, "left"),
        "left flank": _flank_place(member, "left"),
        "right flank": _flank_place(member, "right"),
        "right fillet": _fillet_place(member, "right"),
    }


def _trace(knots: FloatArray, points: FloatArray) -> Trace:
    """Give the line through points (n, 3) at the nodes of its knots."""
    angle = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    angle -= 2.0 * pi * np.round(np.median(angle) / (2.0 * pi))
    poles = _poles(knots, points)
    # Exactly even, as the planes at the ends want it: Greville's nodes are the poles of t.
    poles[:, 2] = points[0, 2] + (points[-1, 2] - points[0, 2]) * _nodes(knots)
    return Trace(knots, poles, _poles(knots, angle))


def _net(place: Place, first: Trace, last: Trace) -> Net:
    across, t = _fitted_knots(lambda s: place(s[:, None], PROBES), FIT), _nodes(first.knots)
    poles = _poles(first.knots, _poles(across, place(_nodes(across)[:, None], t)), axis=1)
    poles[0], poles[-1] = first.points, last.points
    poles[..., 2] = first.points[:, 2]
    return Net(across, poles)


def _cut_tooth(member: Member) -> _Tooth:
    """Fit tooth 0 by B-splines. Raises ValueError for a pointed tooth."""
    places, pitch = _places(member), 2.0 * pi / float(member.teeth)
    lines = [(place, s) for place in places.values() for s in PROBES]
    knots = _fitted_knots(lambda t: np.stack([place(s, t) for place, s in lines], axis=1), FIT_OF_TRACES)
    t, taper = _nodes(knots), tan(float(member.cone_angle))
    tip, root = (Revolved(float(radius(member, 0.0)), taper) for radius in (tip_radius, root_radius))
    starts, ends = ([_trace(knots, place(s, t)) for place in places.values()] for s in (0.0, 1.0))
    left_root, left_tip, right_tip, right_root = starts[0], ends[1], starts[2], ends[3]
    if np.any((right_tip.angle - left_tip.angle) * tip.radius < NARROW):
        raise ValueError("the tooth is pointed: reduce the addendum, the profile shift or the face width")
    has_land = bool(np.all((left_root.angle + pitch - right_root.angle) * root.radius > NARROW))
    if not has_land:
        right_root = _turned(left_root, pitch)
    pairs = (left_root, starts[1]), (starts[1], left_tip), (right_tip, starts[3]), (starts[3], right_root)
    strips = [
        Strip(name, *pair, _net(place, *pair))
        for (name, place), pair in zip(places.items(), pairs, strict=True)
    ]
    strips.insert(2, Strip("tip", left_tip, right_tip, tip))
    return _Tooth(strips, root, _middle(member, knots) if has_land else right_root, has_land)


def _middle(member: Member, knots: FloatArray) -> Trace:
    """Give the middle of the tooth space after tooth 0 on the bottom land."""
    z = 0.5 * float(member.face_width) * (2.0 * _nodes(knots) - 1.0)
    return _trace(knots, bottom_point(member, "right", 0.5 * pi * float(member.tool.normal_module), z)[0])


def _turned(trace: Trace, angle: float) -> Trace:
    return Trace(trace.knots, turned(angle, *np.moveaxis(trace.points, -1, 0)), trace.angle + angle)


def _turned_strip(strip: Strip, angle: float, tooth: int) -> Strip:
    surface = strip.surface
    if isinstance(surface, Net):
        surface = Net(surface.knots, turned(angle, *np.moveaxis(surface.poles, -1, 0)))
    return Strip(strip.name, _turned(strip.first, angle), _turned(strip.last, angle), surface, tooth)


def _whole_bore(member: Member, radius: float) -> list[Strip]:
    """Give the bore of a whole gear as two halves, which run with the clock."""
    half = 0.5 * float(member.face_width)
    line = Trace(STRAIGHT, np.array([[radius, 0.0, -half], [radius, 0.0, half]]), np.zeros(2))
    traces = [_turned(line, -pi * i) for i in range(3)]
    return [Strip("bore", *pair, Revolved(radius, 0.0)) for pair in pairwise(traces)]


def _sector(cut: _Tooth, outline: list[Strip], numbers: list[int], total: int, bore: float) -> list[Strip]:
    """Give the loop round some teeth whose strips, with the spaces after them, are `outline`."""
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


def _ruled(first: Trace, last: Trace) -> Net:
    return Net(STRAIGHT, np.stack((first.points, last.points)))


def _on_cylinder(trace: Trace, radius: float) -> Trace:
    """Give the trace with the same angles on a cylinder."""
    from scipy.interpolate import BSpline

    angle = BSpline(trace.knots, trace.angle, DEGREE)(_nodes(trace.knots))
    points = np.stack((radius * np.cos(angle), radius * np.sin(angle), trace.points[:, 2]), axis=-1)
    inner = _trace(trace.knots, points)
    return Trace(inner.knots, inner.points, trace.angle)
