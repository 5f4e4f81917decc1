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
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .assembly import common_normal, layout_of, member_frame, to_fixed
from .fillet import root_radius
from .flank import root_parameter, tip_radius, tip_thickness, undercut_margin
from .inputs import Design, FloatArray, Member
from .mounting import mounting_of
from .rack import rack_of
from .undercut import CURE, cut_fault, pointed_part, undercut_of, words_of

OFFSET_TOLERANCE = 1.0 / 60.0
SHAFT_ANGLE_TOLERANCE = math.radians(0.01)
"""Differences (modules of the pinion, rad) beyond which a design does not count as closed."""
INTERFERENCE_TOLERANCE = 1.0 / 6000.0
"""Overlap (modules of the pinion) that rounded input explains."""
THIN_TIP = 0.2
"""Tip thickness in modules below which a tooth is apt to be hardened through or to chip."""
SMALL_CLEARANCE = 0.1
"""Tip clearance in modules below which a mounting error or a deflection may use it up."""
SAMPLES = 721
PARALLEL = 1e-12
"""Sine of a shaft angle below which axes count as parallel: rounding of the helix angles leaves no
digits of it."""
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
    interference; `offset`: the one that closes at the design's shaft angle; `shaft_angle`: the
    one that closes at its offset; `offset_difference` and `shaft_angle_difference`: these less
    the design's. NaN where there is none, then `reasons` says why."""

    gap: float
    normal_backlash: float
    offset: float
    offset_difference: float
    shaft_angle: float
    shaft_angle_difference: float
    reasons: tuple[str, ...] = ()


class Remark(NamedTuple):
    """What is to be known about a design: `level` is 'warning' or 'note'."""

    level: str
    text: str


def _only_single(design: Design) -> None:
    if design.batch_shape:
        raise ValueError(f"design must be a single one, got arrays of shape {design.batch_shape}")


def _pressure_angles(design: Design) -> FloatArray:
    """Working pressure angles (rad), ascending, at which both members have a working helix and
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
    """Angle (rad) about the axis between the flanks of a tooth at the pitch point."""
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
    """The closed layout of the members of a single `design` with the working normal pressure
    angle(s) given (rad, any shape). The pair's own offset and shaft angle are not used."""
    aw = np.asarray(pressure_angle, dtype=float)
    gw, bw, rw, thickness = (np.empty((2, *aw.shape)) for _ in range(4))
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
    hand = np.where(design.pinion.helix_angle + np.asarray(design.gear.helix_angle) < 0.0, -1.0, 1.0)
    reach = rw[0] * cosine[1] + rw[1] * cosine[0]
    lean = rw[::-1] * (sine + sine[::-1] * cos_d) / cosine[::-1]
    sin_d = np.where(sin_d > PARALLEL, sin_d, np.nan)
    return ClosedLayout(
        offset=np.asarray(hand * reach * sum_sine / sin_d),
        shaft_angle=np.arctan2(sin_d, cos_d),
        pressure_angle=aw,
        cone_angle=gw,
        helix_angle=bw,
        working_radius=rw,
        mounting=(lean + lean[::-1] * cos_d) / sin_d**2,
        normal_backlash=np.asarray((2.0 * np.pi - thickness[0] - thickness[1]) * base_pitch / (2.0 * np.pi)),
    )


def _roots(function: Callable[[float], float], samples: FloatArray, values: FloatArray) -> list[float]:
    """Zeros of `function` between samples at which its values change sign."""
    from scipy.optimize import brentq  # slow to import

    known = np.isfinite(values[:-1]) & np.isfinite(values[1:])
    cells = np.flatnonzero(known & (np.signbit(values[:-1]) != np.signbit(values[1:])))
    return [float(brentq(function, samples[i], samples[i + 1], xtol=1e-15, rtol=1e-15)) for i in cells]


def zero_backlash_layout(design: Design) -> ClosedLayout:
    """The layout in which the members of a single `design` mesh without backlash, mid-faces at
    the pitch point: offset, shaft angle and mounting distances follow from the gears alone.

    Raises ValueError for arrays, where the members have backlash in every layout that closes, and
    where the axes of the one without meet or are parallel."""
    _only_single(design)

    def backlash(pressure_angle: float) -> float:
        return float(closed_layout(design, np.asarray(pressure_angle)).normal_backlash)

    samples = _pressure_angles(design)
    values = closed_layout(design, samples).normal_backlash
    lowest = int(np.argmin(values)) if samples.size else 0
    roots = _roots(backlash, samples[lowest:], values[lowest:])
    if not roots:
        reason = "the teeth are too thin in all that close, take more profile shift"
        raise ValueError(f"no layout without backlash: {reason if samples.size else 'none closes at all'}")
    found = closed_layout(design, np.asarray(roots[0]))
    if not float(found.offset) > 0.0:
        cause = "the helix angles nearly cancel, the axes would meet or be parallel"
        raise ValueError(f"no layout without backlash: {cause}")
    return found


def _pressure_angle_as_mounted(design: Design) -> float:
    """Working pressure angle (rad) that the two common normals make at the design's shaft angle, if
    their lines meet: half the length of their sum is its sine. NaN without common normals."""
    layout, branch = layout_of(design, with_errors=False), mounting_of(design).branch
    normals = []
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for flank, sign in zip(("right", "left"), branch, strict=True):
            axial = np.array([rack_of(member, flank).normal[2] for member in design.members])
            normal = common_normal(layout, axial)
            normals.append((sign * np.sqrt(normal.x_squared), normal.y[0], axial[0]))
        return float(np.arcsin(0.5 * np.linalg.norm(np.sum(normals, axis=0))))


def closing_offset(design: Design) -> float:
    """Offset (mm) that closes at the design's shaft angle, NaN if there is none."""
    with np.errstate(invalid="ignore"):
        closed = closed_layout(design, np.asarray(_pressure_angle_as_mounted(design)))
    meant = abs(float(closed.shaft_angle) - float(design.pair.shaft_angle)) < AMISS
    return float(closed.offset) if meant else math.nan


def _closing_shaft_angle(design: Design) -> float:
    """Shaft angle (rad) that closes at the design's offset; of several that nearest to the
    design's, NaN if there is none."""

    def excess(pressure_angle: float | FloatArray) -> FloatArray:
        return closed_layout(design, np.asarray(pressure_angle)).offset - design.pair.offset

    samples = _pressure_angles(design)
    roots = _roots(lambda pressure_angle: float(excess(pressure_angle)), samples, excess(samples))
    angles = closed_layout(design, np.array(roots)).shaft_angle
    if not angles.size:
        return math.nan
    return float(angles[np.argmin(np.abs(angles - design.pair.shaft_angle))])


def closing_of(design: Design) -> Closing:
    """How well a single design closes. Raises ValueError for arrays."""
    _only_single(design)
    mounting = mounting_of(design)
    offset, shaft_angle = closing_offset(design), _closing_shaft_angle(design)
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


def _closing_remarks(closing: Closing, module: float) -> Iterator[Remark]:
    for reason in closing.reasons:
        yield Remark("warning", reason)
    off, turned = closing.offset_difference, closing.shaft_angle_difference
    closed = abs(off) <= OFFSET_TOLERANCE * module and abs(turned) <= SHAFT_ANGLE_TOLERANCE
    meets = []
    if not math.isnan(off):
        meets.append(f"an offset of {closing.offset:.4f} mm ({off:+.4f})")
    if not math.isnan(turned):
        at, turned_deg = math.degrees(closing.shaft_angle), math.degrees(turned)
        meets.append(f"a shaft angle of {at:.4f} deg ({turned_deg:+.4f})")
    if meets and not closed:
        apart = "" if math.isnan(closing.gap) else f" pass {closing.gap:.4g} mm apart and"
        text = f"the design does not close: its lines of action{apart} meet at {' or '.join(meets)}"
        yield Remark("warning", text)
    if closing.normal_backlash < -INTERFERENCE_TOLERANCE * module:
        text = f"the teeth interfere by {-closing.normal_backlash:.4f} mm along the normal"
        yield Remark("warning", f"{text}: take a larger offset or less profile shift" if closed else text)


def tip_clearances(design: Design) -> FloatArray:
    """Least distances (2,), mm, of the tip cones of pinion and gear from the root cone of the
    other member, of a single design as mounted, without errors; to about 0.001 mm. NaN where the
    faces do not stand beside each other or the mounting is not known."""
    layout, distance = layout_of(design, with_errors=False), mounting_of(design).distance
    frames = [member_frame(layout, j, 0.0, distance[j]) for j in (0, 1)]
    turn, share = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 721)[:, None], np.linspace(-0.5, 0.5, 65)
    least = np.full(2, np.nan)
    for j, (member, mate) in enumerate((design.members, design.members[::-1])):
        z = share * float(member.face_width)
        radius = tip_radius(member, z)
        tip = np.stack(np.broadcast_arrays(radius * np.cos(turn), radius * np.sin(turn), z), axis=-1)
        rotation, origin = frames[1 - j]
        x, y, along = np.moveaxis((to_fixed(frames[j], tip) - origin) @ rotation, -1, 0)
        gap = (np.hypot(x, y) - root_radius(mate, along)) * np.cos(float(mate.cone_angle))
        beside = np.abs(along) <= 0.5 * float(mate.face_width)
        least[j] = gap[beside].min() if beside.any() else np.nan
    return least


def _clearance_remarks(design: Design) -> Iterator[Remark]:
    for name, mate, member, clearance in zip(
        ("pinion", "gear"), ("gear", "pinion"), design.members, tip_clearances(design), strict=True
    ):
        module = float(member.tool.normal_module)
        if clearance <= 0.0:
            text = f"the tips of the {name} run {-clearance:.3g} mm into the bottom lands of the {mate}"
            yield Remark("warning", f"{text}: take a larger offset, a lower addendum or a deeper tool")
        elif clearance < SMALL_CLEARANCE * module:
            size = f"{clearance:.3g} mm, {clearance / module:.2g} modules"
            yield Remark("note", f"the tip clearance of the {name} is small: {size}")


def _undercut_remarks(name: str, member: Member) -> Iterator[Remark]:
    for flank in ("right", "left"):
        text = f"the {flank} flank of the {name} is undercut"
        try:
            found = undercut_of(member, flank)
        except ValueError as error:
            if flank == "right":
                yield Remark("warning", f"the fillets of the {name} cannot be cut: {error}")
            if not float(undercut_margin(member, flank)) > 0.0:
                yield Remark("warning", f"{text}: {CURE}")
            continue
        if found.undercut:
            active = not np.all(found.start <= float(root_parameter(member)))
            level, where = ("warning", "") if active else ("note", " below its active part")
            yield Remark(level, f"{text}{where} {words_of(found)}: {CURE}")


def _tooth_remarks(name: str, member: Member) -> Iterator[Remark]:
    if fault := cut_fault(member):
        yield Remark("warning", f"the flanks of the {name} cannot be cut: {fault}")
        return
    yield from _undercut_remarks(name, member)
    module, pointed = float(member.tool.normal_module), pointed_part(member)
    for end, z, part in (("heel", 0.5, "from {0:.4g} mm on"), ("toe", -0.5, "up to {1:.4g} mm")):
        thickness = float(tip_thickness(member, z * float(member.face_width)))
        if math.isnan(thickness):
            yield Remark("warning", f"the flanks of the {name} do not reach its tip cone at the {end}")
        elif thickness <= 0.0:
            text = f"the tooth of the {name} is pointed at the {end}, {part.format(*pointed)}"
            yield Remark("warning", f"{text}: take less profile shift or a lower addendum")
        elif thickness < THIN_TIP * module:
            at = f"{thickness:.3g} mm, {thickness / module:.2g} modules, at the {end}"
            yield Remark("note", f"the tooth tip of the {name} is thin: {at}")


def remarks_on(design: Design, closing: Closing | None = None) -> tuple[Remark, ...]:
    """Warnings: the design does not close (by more than OFFSET_TOLERANCE or
    SHAFT_ANGLE_TOLERANCE), the teeth interfere, tips run into bottom lands, the tool's rounds overlap,
    an active flank is undercut, a tooth is pointed; notes: undercut below the active flank, a
    thin tooth tip, a small tip clearance. Raises ValueError for arrays."""
    closing = closing_of(design) if closing is None else closing
    found = list(_closing_remarks(closing, float(design.pinion.tool.normal_module)))
    for name, member in (("pinion", design.pinion), ("gear", design.gear)):
        found += _tooth_remarks(name, member)
    found += _clearance_remarks(design)
    return tuple(found)
