"""Sliding along a path of contact: velocities of the flanks and of the contact, specific sliding.

Everything is per unit of the pinion's speed, mm per rad of its roll: times the pinion's speed in
rad/s, with its sign, it is mm/s. R is the contact point in S_f, n the common normal out of the pinion's
tooth, k_j the axes, O_j a point of each:

    v_j = phi_j' k_j x (R - O_j),   phi_1' = 1,   n.(v_1 - v_2) = 0.

The last is the equation of meshing (Litvin & Fuentes, Gear Geometry and Applied Theory, 2004); it gives
the gear's instantaneous speed phi_2', which with a parabola is not that of the tooth numbers.

The contact point itself moves with V along the path. With T tangent to the path, from its equations
(`parallel.regular`) differentiated by a complex step, V = T n.v_1 / n.T, since the contact stays on the
pinion's flank. Over either flank it runs, in the tangent plane, with

    w_j = V - v_j,   w_2 - w_1 = v_1 - v_2.

Without parabola V is along n, and w_j is the tangential part of -v_j.

Specific sliding. Of cylindrical gears it is the sliding speed over the speed of the member's transverse
profile along its tangent (DIN 3960, ISO 21771): 1 - (rho_2/rho_1)(N1/N2) for the pinion. On crossed axes
each member has a transverse section of its own, and flanks slide along their tooth traces even at the
pitch point. With e_j the tangent of the transverse profile (square to k_j and n), t_j that of the tooth
trace (l = const) and q_j that of the flank square to the trace, e_j and q_j from root to tip,

    zeta_1 = (v_1 - v_2).q_1 / [(v_1.e_1)(e_1.q_1)],   zeta_2 = (v_2 - v_1).q_2 / [(v_2.e_2)(e_2.q_2)],

sliding square to the trace over the same component of the profile's speed. v_j.e_j is phi_j' times the
distance from the base cylinder along the plane of action, the transverse radius of curvature of an
involute. So zeta_j is -inf at the base circle, and 0 at the pitch point of crossed helical gears; on
parallel axes v_1 - v_2 is along e_j, and it is the standards' number, of spur and of helical gears.
Projected on e_j alone, sliding along the trace would count: 1 at the pitch point of 45 deg screw gears.

zeta_j leaves out the sliding along the trace; all of it is in |v_1 - v_2| / |w_j|, the sliding distance
per distance run over. That one is not negative, and falls where a parabola makes the contact run along
the face. The paper has neither.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import COMPLEX_STEP, Codes, FloatArray, flank_sign
from ..contact.equation import contact_point, pairing_of
from ..contact.parallel.lines import touches_along_lines
from ..contact.parallel.regular import (
    meet_regular,
    point_on_curve,
    regular_jacobian,
    tangent_of,
    units_of_all,
)
from ..contact.path import ContactPath
from ..design.model import Design
from ..gear.flank import flank_patch
from ..pair.frames import layout_by_case, layout_of, member_frame, normals_to_fixed
from ..support.few_lines import few_lines


@dataclass(frozen=True, eq=False)
class Sliding:
    """Velocities at the positions of a path, in S_f, mm per rad of pinion roll; NaN where it has none.

    Arrays (*batch, positions): `pinion_roll` (rad) and `status` of the path, `gear_rate` (gear roll by
    pinion roll, negative), `speed` of sliding. Vectors (..., 3): `pinion_velocity` v_1 and
    `gear_velocity` v_2 of the flanks, `contact_velocity` V, `sliding` v_1 - v_2.

    A further axis holds pinion and gear: `rolling` (..., 2, 3), w_j; (..., 2): components of v_1 - v_2,
    `lengthwise` along the member's tooth trace towards the heel, and `profile` square to it from root to
    tip; `specific` sliding along the profile, above 1 where an undercut flank touches inside its base
    circle, and `specific_total`, that of all sliding.

    Speeds are for a pinion that turns in the positive sense, with which it drives right flanks. Where
    it drives left ones all vectors and components turn round; the other numbers stay."""

    __repr__ = few_lines

    flank: str
    pinion_roll: FloatArray
    gear_rate: FloatArray
    pinion_velocity: FloatArray
    gear_velocity: FloatArray
    contact_velocity: FloatArray
    sliding: FloatArray
    speed: FloatArray
    rolling: FloatArray
    profile: FloatArray
    lengthwise: FloatArray
    specific: FloatArray
    specific_total: FloatArray
    status: Codes


def sliding_of(path: ContactPath) -> Sliding:
    """Find velocities and specific sliding at the positions of a path.

    Parameters
    ----------
    path : ContactPath

    Returns
    -------
    Sliding
        Per radian of the pinion's roll, mm. The contact's velocity grows without bound where the pinion's
        roll turns back along the path; all but `contact_velocity`, `rolling` and `specific_total` are
        regular there.
    """
    shape = path.l1.shape
    by_case = (max(1, int(np.prod(shape[:-1]))), shape[-1], 3)
    point, normal = path.point.reshape(by_case), path.normal.reshape(by_case)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        axes, feet = _axes(path.design)
        turning = np.cross(axes, point[..., None, :] - feet)
        lever = _dot(normal[..., None, :], turning)
        rate = lever[..., 0] / lever[..., 1]
        turning[..., 1, :] *= rate[..., None]
        tangent = _path_tangents(path, point, normal)
        contact = tangent * (lever[..., 0] / _dot(normal, tangent))[..., None]
        sliding = turning[..., 0, :] - turning[..., 1, :]
        rolling = contact[..., None, :] - turning
        trace = tooth_traces(path)
        outward = flank_sign(path.flank) * np.stack((normal, -normal), axis=-2)
        upward, transverse = np.cross(outward, trace), _unit(np.cross(outward, axes))
        profile, speed = _dot(sliding[..., None, :], upward), np.linalg.norm(sliding, axis=-1)
        moved = _dot(turning, transverse) * _dot(transverse, upward)
        numbers = {
            "gear_rate": rate,
            "pinion_velocity": turning[..., 0, :],
            "gear_velocity": turning[..., 1, :],
            "contact_velocity": contact,
            "sliding": sliding,
            "speed": speed,
            "rolling": rolling,
            "profile": profile,
            "lengthwise": _dot(sliding[..., None, :], trace),
            "specific": np.array((1.0, -1.0)) * profile / moved,
            "specific_total": speed[..., None] / np.linalg.norm(rolling, axis=-1),
        }
    found = {name: values.reshape(*shape, *values.shape[2:]) for name, values in numbers.items()}
    return Sliding(flank=path.flank, pinion_roll=path.pinion_roll, status=path.status, **found)


def least_sliding(sliding: Sliding) -> tuple[FloatArray, FloatArray]:
    """Find the pinion roll (rad) and speed (mm/rad) of the least sliding on each path, batch shape; NaN where
    there is no path. Exact without parabola, else the speed to the third order of the spacing and the
    roll to the second."""
    roll, square = least_along(sliding.pinion_roll, sliding.speed**2)
    return roll, np.sqrt(np.maximum(square, 0.0))


def least_along(roll: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Find the roll and value (...) at which `values` (..., positions) are least, taken as a parabola
    through the least and its neighbours, which stand at even distances; NaN where no value is known."""
    roll, values = np.asarray(roll, dtype=float), np.asarray(values, dtype=float)
    last = values.shape[-1] - 1
    if last < 0:
        return np.full(values.shape[:-1], np.nan), np.full(values.shape[:-1], np.nan)
    place = np.argmin(np.where(np.isnan(values), np.inf, values), axis=-1)[..., None]
    inside = np.clip(place, 1, last - 1) if last > 1 else place
    three = (inside - 1, inside, inside + 1) if last > 1 else (place, place, place)
    before, now, after = (np.stack([np.take_along_axis(v, at, -1) for v in (roll, values)]) for at in three)
    rate, bend = 0.5 * (after - before), 0.5 * (after + before) - now
    with np.errstate(invalid="ignore", divide="ignore"):
        vertex = np.clip(-0.5 * rate[1] / bend[1], -1.0, 1.0)
    step = np.where(bend[1] > 0.0, vertex, place - inside)
    found, least = (now + step * (rate + step * bend))[..., 0]
    return np.where(np.isnan(least), np.nan, found), least


def _axes(design: Design) -> tuple[FloatArray, FloatArray]:
    """Find directions and feet (cases, 1, 2, 3), mm, of both axes in S_f, errors included."""
    layout = layout_by_case(layout_of(design), design.batch_shape)
    axes, feet = np.zeros((2, *np.shape(layout.offset), 2, 3))
    axes[..., 0, 2], feet[..., 1, 0] = 1.0, layout.offset
    axes[..., 1, 1], axes[..., 1, 2] = layout.sin_angle, layout.cos_angle
    return axes, feet


def _path_tangents(path: ContactPath, point: FloatArray, normal: FloatArray) -> FloatArray:
    """Find tangents (cases, positions, 3) of the path in S_f, of any length and either sense."""
    pairing = pairing_of(path.design, path.flank)
    l1, l2 = (values.reshape(normal.shape[:-1]) for values in (path.l1, path.l2))
    y, lines = point_on_curve(point, normal, l1, l2), touches_along_lines(path.design, path.flank)
    lines = np.broadcast_to(lines.reshape(-1, 1), l1.shape)
    tangent = np.moveaxis(tangent_of(regular_jacobian(pairing, y)[1], lines), -1, 0)
    met = meet_regular(pairing, y + COMPLEX_STEP * 1j * tangent * units_of_all(pairing))[1]
    found = np.moveaxis(contact_point(met).imag / COMPLEX_STEP, 0, -1)
    plain = (np.asarray(pairing.rack.parabola) == 0.0).all(axis=0)
    return np.where((lines & plain)[..., None], normal, found)


def tooth_traces(path: ContactPath) -> FloatArray:
    """Find the unit tangents (cases, positions, 2, 3) in S_f of the lines of constant l through the
    contacts, on pinion and gear, towards the heel."""
    design, cases = path.design, max(1, int(np.prod(path.l1.shape[:-1])))
    l, u, roll = (
        np.stack([values.reshape(cases, -1 if values.size else 0) for values in pair])
        for pair in ((path.l1, path.l2), (path.u1, path.u2), (path.pinion_roll, path.gear_roll))
    )
    tangents = flank_patch(design.stacked_members(), path.flank, l, u).tangent_u
    layout = layout_by_case(layout_of(design), design.batch_shape)
    frames = [member_frame(layout, j, roll[j], 0.0) for j in (0, 1)]
    fixed = [normals_to_fixed(frame, tangent) for frame, tangent in zip(frames, tangents, strict=True)]
    return _unit(np.stack(fixed, axis=-2))


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray((first * second).sum(axis=-1))
