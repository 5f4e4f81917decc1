"""Frames of the mounted pair and its assembly errors (Eqs. 7-14, Figs. 4 and 5).

S_f is fixed: z along the pinion axis towards +z of the pinion, x along the common perpendicular from the
pinion axis to the gear axis, origin at its foot on the pinion axis. The gear axis passes through (E, 0, 0)
along k2 = (0, sin d, cos d) with the shaft angle d. The fixed frame of the gear has X2 = -x, Z2 = k2 and
Y2 = Z2 x X2, so that exchanging pinion and gear changes no formula. A positive roll is about +k_j. At roll
0 the frame of a member coincides with its fixed frame, shifted along the axis by the mounting distance, and
its generating rack is at phi = 0.

The shaft angle has the sign of the sum of the helix angles, so that a left-hand pinion gives the mirror
image. A design contains its magnitude, to which the shaft-angle error is added.

Difference from the paper: the paper places the errors of offset and shaft angle on both sides of S_f
(Fig. 5). Here the pinion axis is fixed and the gear is moved: the same pair, seen from the pinion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray, Quantity
from ..design.model import NORMAL_MATCH_TOLERANCE, PARALLEL_AXES_SINE, Design, Errors


@dataclass(frozen=True, eq=False)
class Layout:
    """Axes of the pair.

    `offset` E in mm; signed `shaft_angle` d in rad, with sin(d), cos(d) and 1 - cos(d) (`versed_angle`),
    which keep their digits for nearly parallel axes; `sense`, the sign with which a shaft-angle error is
    added.
    """

    offset: Quantity
    shaft_angle: Quantity
    sense: Quantity
    sin_angle: Quantity
    cos_angle: Quantity
    versed_angle: Quantity

    @property
    def parallel(self) -> NDArray[np.bool_]:
        """Whether the axes are parallel."""
        return np.asarray(np.abs(self.sin_angle) <= PARALLEL_AXES_SINE)


@dataclass(frozen=True, eq=False)
class CommonNormal:
    """Common unit normal at contact, out of the pinion tooth, in S_f.

    `x_squared` is n_x^2. `y` has pinion and gear on the leading axis: the y component of the outward normal
    of the member in its fixed frame. The x component is the same in both frames; its sign is a property of
    the design (see `mounting`).
    """

    x_squared: FloatArray
    y: FloatArray


def layout_of(design: Design, with_errors: bool = True) -> Layout:
    """Return the axes of the pair, with or without its assembly errors."""
    return layout_at(*_axes(design, design.errors if with_errors else Errors()))


def layout_by_case(design: Design) -> Layout:
    """Return the layout with its errors, each quantity of shape (cases, 1), to broadcast with positions."""
    axes, shape = _axes(design, design.errors), design.batch_shape
    return layout_at(*(np.broadcast_to(x, shape).reshape(-1, 1) if shape else x.reshape(1, 1) for x in axes))


def _axes(design: Design, errors: Errors) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return offset (mm), signed shaft angle (rad) and its sense."""
    sense = design.sense
    angle = np.asarray(sense * (design.pair.shaft_angle + errors.shaft_angle))
    return np.asarray(design.pair.offset + errors.offset), angle, sense


def layout_at(offset: Any, angle: Any, sense: Any) -> Layout:
    """Return the axes at an offset, mm, and a signed shaft angle, rad, which may be complex."""
    return Layout(offset, angle, sense, np.sin(angle), np.cos(angle), 2.0 * np.sin(0.5 * angle) ** 2)


def common_normal(layout: Layout, axial: FloatArray | tuple[FloatArray, FloatArray]) -> CommonNormal:
    """Return the common normal of two flanks whose outward unit normals have the axial components `axial`.

    Pinion and gear may have shapes that broadcast. With the normal n of the pinion, n.k1 = v1 and n.k2 = -v2
    give n_y = -(v2 + v1 cos d)/sin d, in a form that is exact for small d. `x_squared` is negative where no
    common normal exists.
    """
    both = axial[0] + axial[1]
    y = np.array([(layout.versed_angle * v - both) / layout.sin_angle for v in axial])
    return CommonNormal(1.0 - axial[0] * axial[0] - y[0] * y[0], y)


def parallel_normal(layout: Layout, axial: FloatArray, moment: FloatArray) -> CommonNormal:
    """Return the common normal on parallel axes.

    The outward unit normals of the flanks have the axial components `axial` and the moments `moment` about
    their axes, mm, pinion first. n.k1 = v1 and n.k2 = -v2 are a single equation there: it requires v1 + v2 =
    0 and leaves n_y free. The moments g1, g2 of the line of action about both axes give E n_y = g1 + g2. NaN
    if v1 + v2 exceeds NORMAL_MATCH_TOLERANCE.
    """
    y = (moment[0] + moment[1]) / layout.offset
    y = np.where(np.abs(axial[0] + axial[1]) <= NORMAL_MATCH_TOLERANCE, y, np.nan)
    return CommonNormal(1.0 - axial[0] * axial[0] - y * y, np.array((y, y)))


def normal_of_unmodified(layout: Layout, axial: FloatArray, moment: FloatArray) -> CommonNormal:
    """Return the common normal of unmodified flanks: `parallel_normal` on parallel axes, else
    `common_normal`.
    """
    crossed, parallel = common_normal(layout, axial), layout.parallel
    if not parallel.any():
        return crossed
    limit = parallel_normal(layout, axial, moment)
    return CommonNormal(
        np.where(parallel, limit.x_squared, crossed.x_squared), np.where(parallel, limit.y, crossed.y)
    )


def member_frame(
    layout: Layout, member: int, roll: ArrayLike, axial_position: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return the rotation (..., 3, 3) and origin (..., 3), mm, that transform from the frame of a member to
    S_f.

    `x_f = rotation @ x_j + origin` (Eqs. 7-14). `member` is 0 for the pinion and 1 for the gear; `roll` is in
    rad; `axial_position` is mounting distance plus axial error, mm.
    """
    roll, position = np.asarray(roll, dtype=float), np.asarray(axial_position, dtype=float)
    shape = np.broadcast_shapes(
        roll.shape, position.shape, np.shape(layout.offset), np.shape(layout.sin_angle)
    )
    cos, sin = np.cos(roll), np.sin(roll)
    turn = np.zeros((*shape, 3, 3))
    turn[..., 0, 0] = turn[..., 1, 1] = cos
    turn[..., 0, 1], turn[..., 1, 0] = -sin, sin
    turn[..., 2, 2] = 1.0
    origin = np.zeros((*shape, 3))
    if member == 0:
        origin[..., 2] = position
        return turn, origin
    axes = np.zeros((*shape, 3, 3))
    axes[..., 0, 0] = -1.0  # X2 = -x
    axes[..., 1, 1], axes[..., 2, 1] = -layout.cos_angle, layout.sin_angle  # Y2 = k2 x X2
    axes[..., 1, 2], axes[..., 2, 2] = layout.sin_angle, layout.cos_angle  # Z2 = k2
    origin[..., 0] = layout.offset
    origin[..., 1] = layout.sin_angle * position
    origin[..., 2] = layout.cos_angle * position
    return axes @ turn, origin


def to_fixed(frame: tuple[FloatArray, FloatArray], points: FloatArray) -> FloatArray:
    """Return points (..., 3) of the frame of a member in S_f, mm (Eq. 7)."""
    rotation, origin = frame
    return np.asarray(np.einsum("...ij,...j->...i", rotation, points) + origin)


def normals_to_fixed(frame: tuple[FloatArray, FloatArray], normals: FloatArray) -> FloatArray:
    """Return directions (..., 3) of the frame of a member in S_f (Eq. 8)."""
    return np.asarray(np.einsum("...ij,...j->...i", frame[0], normals))
