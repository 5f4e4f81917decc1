"""Sliding along a path of contact: velocities of the flanks and of the contact, specific sliding.

All velocities are per unit of the pinion speed, mm per rad of its roll. Multiplied by the pinion speed in
rad/s, with its sign, they are mm/s. Vectors are in the fixed frame S_f (`pair.frames`). With the contact
point R, the common normal n out of the pinion tooth, the directions k_j of the axes, a point O_j of each
axis, and the speeds phi_j' relative to that of the pinion,

    v_j = phi_j' k_j x (R - O_j),   phi_1' = 1,   n.(v_1 - v_2) = 0.

The last equation is the equation of meshing (Litvin & Fuentes, Gear Geometry and Applied Theory, 2004). It
gives the instantaneous speed phi_2' of the gear, which with a parabola differs from the ratio of the tooth
numbers.

The contact point moves with V along the path. The tangent T of the path follows from the path equations
(`contact.parallel.small_angle_equations`), differentiated by a complex step. Because the contact stays on the
pinion flank, V = T n.v_1 / n.T. Over each flank, the contact moves in the tangent plane with

    w_j = V - v_j,   w_2 - w_1 = v_1 - v_2.

Without parabola, V is along n, and w_j is the tangential part of -v_j.

Specific sliding. For cylindrical gears, it is the sliding speed divided by the speed of the member's
transverse profile along its tangent (DIN 3960, ISO 21771): 1 - (rho_2/rho_1)(N1/N2) for the pinion. On
crossed axes, each member has its own transverse section, and the flanks slide along their tooth traces even
at the pitch point. With the tangent e_j of the transverse profile (perpendicular to k_j and n), the tangent
t_j of the tooth trace (l = const) and the tangent q_j of the flank perpendicular to the trace, e_j and q_j
from root to tip,

    zeta_1 = (v_1 - v_2).q_1 / [(v_1.e_1)(e_1.q_1)],   zeta_2 = (v_2 - v_1).q_2 / [(v_2.e_2)(e_2.q_2)],

which is the sliding perpendicular to the trace divided by the same component of the profile speed. v_j.e_j is
phi_j' times the distance from the base cylinder along the plane of action, the transverse radius of curvature
of an involute. Therefore zeta_j is -inf at the base circle and 0 at the pitch point of crossed helical gears.
On parallel axes v_1 - v_2 is along e_j, and zeta_j is the specific sliding of the standards for spur and
helical gears. With a projection on e_j alone, the sliding along the trace would count: 1 at the pitch point
of 45 deg screw gears.

zeta_j excludes the sliding along the trace. The total specific sliding |v_1 - v_2| / |w_j| includes it; it is
the sliding distance per distance travelled by the contact on the flank. It is not negative, and decreases if
a parabola makes the contact move along the face. The paper contains neither quantity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import COMPLEX_STEP, Codes, FloatArray, flank_sign
from ..contact.equation import contact_point
from ..contact.flank_pair import is_modified, pairing_of
from ..contact.parallel.lines import touches_along_lines
from ..contact.parallel.small_angle_equations import (
    meet_regular,
    point_on_curve,
    regular_jacobian,
    tangent_of,
    units_of_all,
)
from ..contact.path import ContactPath
from ..contact.surfaces.second_order import path_tangents
from ..design.arguments import require_path
from ..design.model import Design
from ..gear.flank import flank_patch
from ..pair.frames import layout_by_case, member_frame, normals_to_fixed
from ..support.array_repr import short_repr


@dataclass(frozen=True, eq=False)
class Sliding:
    """Velocities at the positions of a path, in S_f, mm per rad of pinion roll; NaN without a path.

    Speeds are those of a pinion that turns in the positive sense, in which it drives right flanks. If it
    drives left flanks, all vectors and components change sign; the other quantities do not.

    Attributes
    ----------
    pinion_roll, gear_rate : FloatArray
        (..., positions), pinion roll, rad, and gear roll per pinion roll, negative.
    pinion_velocity, gear_velocity : FloatArray
        (..., 3), velocities v_1 and v_2 of the flanks.
    contact_velocity : FloatArray
        (..., 3), velocity V of the contact point.
    sliding, speed : FloatArray
        (..., 3) and (...), v_1 - v_2 and its magnitude.
    rolling : FloatArray
        (..., 2, 3), w_j of pinion and gear.
    profile, lengthwise : FloatArray
        (..., 2), components of v_1 - v_2 perpendicular to the tooth trace of the member, from root to tip,
        and along it, towards +z.
    specific, specific_total : FloatArray
        (..., 2), specific sliding along the profile; sliding in all directions divided by the distance that
        the contact moves on the flank. `specific` is above 1 where an undercut flank touches on the branch
        beyond the base circle, whose radius of curvature is negative.
    status : Codes
        Codes of `Status` of the path.
    """

    __repr__ = short_repr

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


def path_sliding(path: ContactPath) -> Sliding:
    """Compute velocities and specific sliding at the positions of a path.

    Parameters
    ----------
    path : ContactPath

    Returns
    -------
    Sliding
        mm per radian of pinion roll. The velocity of the contact is unbounded where the pinion roll turns
        back along the path; all quantities except `contact_velocity`, `rolling` and `specific_total` are
        regular there.

    References
    ----------
    Equation of meshing: Litvin and Fuentes, Gear Geometry and Applied Theory, 2004; specific sliding:
    ISO 21771.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> path = bg.path_of_contact(bg.builtin_design("ni-2017"), points=3)
    >>> print(f"{bg.path_sliding(path).speed.max():.2f} mm per rad")
    34.94 mm per rad
    """
    require_path(path)
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
    quantities = {name: values.reshape(*shape, *values.shape[2:]) for name, values in numbers.items()}
    return Sliding(flank=path.flank, pinion_roll=path.pinion_roll, status=path.status, **quantities)


def least_sliding(sliding: Sliding) -> tuple[FloatArray, FloatArray]:
    """Return pinion roll and speed of the smallest sliding on each path.

    The result is exact without parabola. Otherwise the speed has an error of third order in the spacing, the
    roll of second order.

    Parameters
    ----------
    sliding : Sliding
        Sliding along one path or a batch.

    Returns
    -------
    roll : ndarray
        Pinion roll, rad, batch shape; NaN without a path.
    speed : ndarray
        Sliding speed, mm/rad, batch shape.
    """
    roll, square = least_along(sliding.pinion_roll, sliding.speed**2)
    return roll, np.sqrt(np.maximum(square, 0.0))


def least_along(roll: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the roll and value (...) of the minimum of `values` (..., positions), by a parabola through the
    smallest value and its neighbours, which must be evenly spaced; NaN if no value is known."""
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
    least_roll, least = (now + step * (rate + step * bend))[..., 0]
    return np.where(np.isnan(least), np.nan, least_roll), least


def _axes(design: Design) -> tuple[FloatArray, FloatArray]:
    """Return directions and feet (cases, 1, 2, 3), mm, of both axes in S_f, with errors."""
    layout = layout_by_case(design)
    axes, feet = np.zeros((2, *np.shape(layout.offset), 2, 3))
    axes[..., 0, 2], feet[..., 1, 0] = 1.0, layout.offset
    axes[..., 1, 1], axes[..., 1, 2] = layout.sin_angle, layout.cos_angle
    return axes, feet


def _path_tangents(path: ContactPath, point: FloatArray, normal: FloatArray) -> FloatArray:
    """Return tangents (cases, positions, 3) of the path in S_f, of any length and sense."""
    if is_modified(path.design, path.flank):
        return path_tangents(path)
    pairing = pairing_of(path.design, path.flank)
    l1, l2 = (values.reshape(normal.shape[:-1]) for values in (path.l1, path.l2))
    y, lines = point_on_curve(point, normal, l1, l2), touches_along_lines(path.design, path.flank)
    lines = np.broadcast_to(lines.reshape(-1, 1), l1.shape)
    tangent = np.moveaxis(tangent_of(regular_jacobian(pairing, y)[1], lines), -1, 0)
    met = meet_regular(pairing, y + COMPLEX_STEP * 1j * tangent * units_of_all(pairing))[1]
    point_rate = np.moveaxis(contact_point(met).imag / COMPLEX_STEP, 0, -1)
    return np.where((lines & pairing.without_parabola[:, None])[..., None], normal, point_rate)


def tooth_traces(path: ContactPath) -> FloatArray:
    """Return the unit tangents (cases, positions, 2, 3) in S_f of the lines of constant l through the
    contacts, on pinion and gear, towards +z."""
    design, cases = path.design, max(1, int(np.prod(path.l1.shape[:-1])))
    l, u, roll = (
        np.stack([values.reshape(cases, -1 if values.size else 0) for values in pair])
        for pair in ((path.l1, path.l2), (path.u1, path.u2), (path.pinion_roll, path.gear_roll))
    )
    tangents = flank_patch(design.stacked_members(), path.flank, l, u).tangent_u
    layout = layout_by_case(design)
    frames = [member_frame(layout, j, roll[j], 0.0) for j in (0, 1)]
    fixed = [normals_to_fixed(frame, tangent) for frame, tangent in zip(frames, tangents, strict=True)]
    return _unit(np.stack(fixed, axis=-2))


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray((first * second).sum(axis=-1))
