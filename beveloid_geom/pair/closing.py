"""How well a design closes: the layouts in which its two lines of action meet.

A rounded design does not close exactly: its lines of action pass each other. The layouts that
close exactly are a family of one parameter, the working normal pressure angle a_w. Where the
lines meet, the two common normals lie at a_w to the working pitch plane and equally far to both
sides of its normal N,

    n = sin(a_w) N +/- cos(a_w) b,   b square to the tooth trace in that plane.

The rack gives the axial components of both normals of a member and their moments about its
axis, m_n N cos(alpha)/2 on either flank. Half the sum and half the difference are

    sin(g_w) sin(a_w)          = sin(alpha) sin(gamma)
    sin(b_w) cos(g_w) cos(a_w) = cos(alpha) cos(gamma) sin(beta)
    r_w cos(a_w) cos(b_w)      = m_n N cos(alpha) / 2

for the working cone angle g_w, helix angle b_w and radius r_w. Put together at the pitch point P
they give the axes, and with them shaft angle, offset and mounting distances. The rolls at which
either flank of a member passes P give its tooth thickness there, and with it the backlash.

A closed layout has zero backlash for one a_w, the given offset for one and the given shaft angle
for one; three different ones in a rounded design. The backlash first falls with a_w and then
rises (it has a false zero far below the tool's pressure angle if a cone angle is not zero): the
zero at which it rises is taken.

All of it holds for unmodified flanks without assembly errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..design.model import Design, Member
from ..gear.rack import rack_of
from .frames import layout_of, normal_of_unmodified
from .mounting import mounting_of

SAMPLES = 721
HALVINGS = 64
"""Halvings of the interval between two samples that find a root to the last digit."""
ROUNDING = 1e-12
"""Sine of a shaft angle below which axes count as parallel, and of a sum of working helix angles below which
they intersect: rounding of the helix angles leaves no digits of it."""
CLOSED = 1e-10
"""Difference (modules) of the offset from that which closes below which the design closes as it is."""
AMISS = 1e-6
"""rad by which the shaft angle of a layout found from its pressure angle may miss that asked for."""


@dataclass(frozen=True, eq=False)
class ClosedLayout:
    """Layout in which the lines of action meet, of unmodified flanks without errors.

    `offset` (mm), `shaft_angle` (magnitude, rad) and `pressure_angle` (working, normal, rad);
    for pinion and gear on the leading axis (2, ...) `cone_angle` and `helix_angle` (working,
    rad), `working_radius` and `mounting` (axial coordinate of the pitch point, mm);
    `normal_backlash` (mm) with mid-faces mounted there. If both cone angles are zero `mounting`
    is zero: the pitch point lies on the common perpendicular, and any other distance serves."""

    offset: FloatArray
    shaft_angle: FloatArray
    pressure_angle: FloatArray
    cone_angle: FloatArray
    helix_angle: FloatArray
    working_radius: FloatArray
    mounting: FloatArray
    normal_backlash: FloatArray


@dataclass(frozen=True)
class Closing:
    """How far a design is from one that closes; mm and rad, for unmodified flanks without errors.

    `gap`: least distance of the two lines of action; `normal_backlash` as mounted, negative for
    interference; `offset`: the one that closes at the design's shaft angle, negative where the axes would
    cross in the other sense; `shaft_angle`: the one that closes at its offset; `offset_difference` and
    `shaft_angle_difference`: these less the design's. NaN where there is none, then `reasons` says why."""

    gap: float
    normal_backlash: float
    offset: float
    offset_difference: float
    shaft_angle: float
    shaft_angle_difference: float
    reasons: tuple[str, ...] = ()


def _only_single(design: Design) -> None:
    if design.batch_shape:
        raise ValueError(f"design must be a single one, got arrays of shape {design.batch_shape}")


def _pressure_angles(design: Design) -> FloatArray:
    """Find the working pressure angles (rad), ascending, at which both members have a working helix and
    cone angle; empty if there are none.

    cos(b_w) = 0 bounds them: with s = sin^2(a_w), A = sin^2(alpha) sin^2(gamma) and
    C = cos^2(alpha) cos^2(gamma) sin^2(beta), (1 - s)(1 - A/s) = C is quadratic in s."""
    low, high = 0.0, 1.0
    for member in design.members:
        alpha, gamma = member.tool.normal_pressure_angle, member.cone_angle
        floor = float(np.sin(alpha) * np.sin(gamma)) ** 2
        ceiling = float(np.cos(alpha) * np.cos(gamma) * np.sin(member.helix_angle)) ** 2
        middle = 0.5 * (1.0 + floor - ceiling)
        half = math.sqrt(max(middle * middle - floor, 0.0))
        low, high = max(low, floor / (middle + half)), min(high, middle + half)
    if low >= high:
        return np.empty(0)
    first, last = math.asin(math.sqrt(low)), math.asin(math.sqrt(high))
    return first + (last - first) * np.linspace(1e-6, 1.0 - 1e-6, SAMPLES)


def _thickness(member: Member, aw: FloatArray, gw: FloatArray, bw: FloatArray, rw: FloatArray) -> FloatArray:
    """Find the angle (rad) about the axis between the flanks of a tooth at the pitch point."""
    roll = {}
    for flank in ("left", "right"):
        rack = rack_of(member, flank)
        nx, ny, nz = rack.normal
        x0, y0, z0 = rack.apex
        radial = (np.sin(aw) + np.sin(gw) * nz) / np.cos(gw)
        around = rack.sigma * np.cos(aw) * np.cos(bw)
        start = nx * (rack.pitch_radius + x0) + ny * y0 + nz * z0
        turned = np.arctan2(around, radial) - np.arctan2(ny, nx)
        roll[flank] = turned - (start - rw * radial) / (rack.pitch_radius * ny)
    return np.asarray(roll["left"] - roll["right"])


def closed_layout(design: Design, pressure_angle: FloatArray) -> ClosedLayout:
    """Give the closed layout of the members of a `design` with the working normal pressure angle(s) given
    (rad, any shape, that broadcasts with the design's). The pair's own offset and shaft angle are not
    used."""
    aw = np.asarray(pressure_angle, dtype=float)
    shape = np.broadcast_shapes(aw.shape, design.batch_shape)
    gw, bw, rw, thickness = (np.empty((2, *shape)) for _ in range(4))
    for j, member in enumerate(design.members):
        alpha, beta, gamma = member.tool.normal_pressure_angle, member.helix_angle, member.cone_angle
        base_pitch = np.pi * member.tool.normal_module * np.cos(alpha)  # the same for both
        lever = base_pitch * member.teeth / (2.0 * np.pi)
        gw[j] = np.arcsin(np.sin(alpha) * np.sin(gamma) / np.sin(aw))
        bw[j] = np.arcsin(np.cos(alpha) * np.cos(gamma) * np.sin(beta) / (np.cos(aw) * np.cos(gw[j])))
        rw[j] = lever / (np.cos(aw) * np.cos(bw[j]))
        thickness[j] = member.teeth * _thickness(member, aw, gw[j], bw[j], rw[j])
    # Axes by their components across the trace, along it and along N: (-sin b cos g, cos b cos g,
    # -sin g) and, other signs, the gear's. Their cross product by the sum of the helix angles, of
    # which the offset is a multiple: so nearly parallel axes keep their digits.
    sine, cosine, sum_sine = np.sin(gw), np.cos(gw), np.sin(bw[0] + bw[1])
    (sin_1, sin_2), (cos_1, cos_2) = np.sin(bw) * cosine, np.cos(bw) * cosine
    cos_d = cos_1 * cos_2 - sin_1 * sin_2 - sine[0] * sine[1]
    square = (sine[0] * cos_2 + sine[1] * cos_1) ** 2 + (sine[0] * sin_2 - sine[1] * sin_1) ** 2
    sin_d = np.sqrt(square + (cosine[0] * cosine[1] * sum_sine) ** 2)
    reach = rw[0] * cosine[1] + rw[1] * cosine[0]
    lean = rw[::-1] * (sine + sine[::-1] * cos_d) / cosine[::-1]
    parallel = (
        sin_d <= ROUNDING
    )  # cones and helix angles cancel: r_w1 + r_w2 apart, mid-face against mid-face
    with np.errstate(invalid="ignore", divide="ignore"):
        offset = np.where(parallel, rw[0] + rw[1], design.sense * reach * sum_sine / sin_d)
        mounting = np.where(parallel, 0.0, (lean + lean[::-1] * cos_d) / sin_d**2)
    return ClosedLayout(
        offset=np.asarray(offset),
        shaft_angle=np.where(parallel, 0.0, np.arctan2(sin_d, cos_d)),
        pressure_angle=aw,
        cone_angle=gw,
        helix_angle=bw,
        working_radius=rw,
        mounting=mounting,
        normal_backlash=np.asarray((2.0 * np.pi - thickness[0] - thickness[1]) * base_pitch / (2.0 * np.pi)),
    )


def _roots(function: Callable[[FloatArray], FloatArray], samples: FloatArray) -> FloatArray:
    """Find zeros of a vectorised `function` between samples at which its values change sign. All are halved
    at once: scipy's root finders take longer to import than that."""
    values = function(samples)
    known = np.isfinite(values[:-1]) & np.isfinite(values[1:])
    cells = np.flatnonzero(known & (np.signbit(values[:-1]) != np.signbit(values[1:])))
    low, high, below = samples[cells], samples[cells + 1], np.signbit(values[cells])
    for _ in range(HALVINGS if cells.size else 0):
        middle = 0.5 * (low + high)
        same = np.signbit(function(middle)) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


def zero_backlash_layout(design: Design) -> ClosedLayout:
    """Find the layout in which two members mesh without backlash, mid-faces at the pitch point.

    Offset, shaft angle and mounting distances follow from the gears alone; of the design's pair only the
    shaft angle is looked at, for the sense in which the axes lean.

    Parameters
    ----------
    design : Design
        A single one; parabolas and errors do not matter.

    Returns
    -------
    ClosedLayout
        `offset`, `mounting` in mm, `shaft_angle` in rad. A negative offset, of helix angles that nearly
        cancel, is one in the other sense than `Design.sense`, which no design has: at the helix angle at
        which it vanishes the axes intersect.

    Raises
    ------
    ValueError
        For arrays, and where the members have backlash in every layout that closes.
    """
    _only_single(design)

    def backlash(pressure_angle: FloatArray) -> FloatArray:
        return closed_layout(design, pressure_angle).normal_backlash

    samples = _pressure_angles(design)
    lowest = int(np.argmin(backlash(samples))) if samples.size else 0
    roots = _roots(backlash, samples[lowest:])
    if not roots.size:
        reason = "the teeth are too thin in all that close"
        raise ValueError(f"no layout without backlash: {reason if samples.size else 'none closes at all'}")
    found = closed_layout(design, roots[0])
    return replace(found, offset=np.asarray(0.0)) if _meet(found) else found


def _meet(layout: ClosedLayout) -> bool:
    """Tell whether the axes of a single layout intersect."""
    return bool(layout.shaft_angle > 0.0) and abs(float(np.sum(layout.helix_angle))) < ROUNDING


def _pressure_angle_as_mounted(design: Design) -> float:
    """Find the working pressure angle (rad) that the two common normals make at the design's shaft angle, if
    their lines meet: half the length of their sum is its sine. NaN without common normals."""
    layout, branch = layout_of(design, with_errors=False), mounting_of(design).branch
    normals = []
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for flank, sign in zip(("right", "left"), branch, strict=True):
            racks = [rack_of(member, flank) for member in design.members]
            axial = np.array([rack.normal[2] for rack in racks])
            moment = np.array([rack.pitch_radius * rack.normal[1] for rack in racks])
            normal = normal_of_unmodified(layout, axial, moment)
            normals.append((sign * np.sqrt(normal.x_squared), normal.y[0], axial[0]))
        return float(np.arcsin(0.5 * np.linalg.norm(np.sum(normals, axis=0))))


def closing_offset(design: Design) -> float:
    """Find the offset (mm) that closes at the design's shaft angle, NaN if there is none."""
    with np.errstate(invalid="ignore"):
        closed = closed_layout(design, np.asarray(_pressure_angle_as_mounted(design)))
    if not abs(float(closed.shaft_angle) - float(design.pair.shaft_angle)) < AMISS:
        return math.nan
    return 0.0 if _meet(closed) else float(closed.offset)


def _closing_shaft_angle(design: Design, offset: float) -> float:
    """Find the shaft angle (rad) that closes at the design's offset; of several that nearest to the
    design's, NaN if there is none. `offset` (mm) is the one that closes at the design's shaft angle.

    Straight teeth on axes that intersect close at every shaft angle of the family: the nearest of its
    samples is taken."""
    near = CLOSED * float(design.pinion.tool.normal_module)
    if abs(offset - float(design.pair.offset)) < near:
        return float(design.pair.shaft_angle)

    def excess(pressure_angle: FloatArray) -> FloatArray:
        return closed_layout(design, pressure_angle).offset - design.pair.offset

    samples = _pressure_angles(design)
    if samples.size and np.abs(excess(samples)).max() > near:
        samples = _roots(excess, samples)
    angles = closed_layout(design, samples).shaft_angle
    if not angles.size:
        return math.nan
    return float(angles[np.argmin(np.abs(angles - design.pair.shaft_angle))])


def closing_of(design: Design) -> Closing:
    """Say how well a single design closes. Raises ValueError for arrays."""
    _only_single(design)
    mounting = mounting_of(design)
    offset = closing_offset(design)
    shaft_angle = _closing_shaft_angle(design, offset)
    reasons = []
    if math.isnan(offset):
        given = f"{math.degrees(design.pair.shaft_angle):.6g} deg"
        lost = math.isnan(_pressure_angle_as_mounted(design))
        why = "the flanks have no common normal" if lost else "the lines of action do not meet"
        reasons.append(f"{why} at a shaft angle of {given}: no offset closes it")
    if math.isnan(shaft_angle):
        reasons.append(f"no shaft angle closes it at an offset of {design.pair.offset:.6g} mm")
    return Closing(
        gap=abs(float(mounting.gap)),
        normal_backlash=float(mounting.normal_backlash),
        offset=offset,
        offset_difference=offset - float(design.pair.offset),
        shaft_angle=shaft_angle,
        shaft_angle_difference=shaft_angle - float(design.pair.shaft_angle),
        reasons=tuple(reasons),
    )
