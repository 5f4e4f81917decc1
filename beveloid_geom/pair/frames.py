"""Frames of the mounted pair and its assembly errors (Eqs. 7-14, Figs. 4 and 5).

S_f is fixed: z along the pinion axis towards the pinion's heel, x along the common
perpendicular from the pinion axis to the gear axis, origin at its foot. The gear axis goes
through (E, 0, 0) along k2 = (0, sin d, cos d) with the shaft angle d. The gear's own fixed
frame has X2 = -x, Z2 = k2, Y2 = Z2 x X2, so that each member sees the other in the same way:
exchanging pinion and gear changes no formula. A positive roll turns about +k_j; at roll 0 a
member's frame coincides with its fixed frame, `mounting` further along the axis, and its
generating rack stands at phi = 0.

The shaft angle takes the sign of the sum of the helix angles, so that a left-hand pinion
gives the mirror image; a design holds its magnitude, to which the shaft-angle error adds.

Difference to the paper: it lays the errors of offset and shaft angle on either side of S_f
(Fig. 5); here the pinion axis stays and the gear moves, the same pair seen from the pinion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray, Quantity
from ..design.model import MATCH, PARALLEL, Design, Errors


@dataclass(frozen=True, eq=False)
class Layout:
    """Axes of the pair: offset E (mm) and signed shaft angle d (rad), with the functions of
    it that keep their digits when the axes are nearly parallel, and the sign with which its errors count."""

    offset: Quantity
    shaft_angle: Quantity
    sense: Quantity
    sin_angle: Quantity
    cos_angle: Quantity
    versed_angle: Quantity

    @property
    def parallel(self) -> NDArray[np.bool_]:
        """Say whether the axes are parallel."""
        return np.asarray(np.abs(self.sin_angle) <= PARALLEL)


@dataclass(frozen=True, eq=False)
class CommonNormal:
    """Common unit normal at contact, out of the pinion tooth, in S_f.

    `x_squared` and, for pinion and gear on the leading axis, `y`: the y component of the
    member's own outward normal in its own fixed frame. The x component is the same in both
    frames; its sign is a property of the design (see `mounting`)."""

    x_squared: FloatArray
    y: FloatArray


def layout_of(design: Design, with_errors: bool = True) -> Layout:
    """Find the axes of the pair, with or without its assembly errors."""
    errors = design.errors if with_errors else Errors()
    angle = np.asarray(design.sense * (design.pair.shaft_angle + errors.shaft_angle))
    offset = design.pair.offset + errors.offset
    return layout_at(np.asarray(offset), angle, design.sense)


def layout_at(offset: Any, angle: Any, sense: Any) -> Layout:
    """Give the axes at an offset, mm, and a signed shaft angle, rad, which may be complex."""
    return Layout(offset, angle, sense, np.sin(angle), np.cos(angle), 2.0 * np.sin(0.5 * angle) ** 2)


def layout_by_case(layout: Layout, batch_shape: tuple[int, ...]) -> Layout:
    """Give the layout with every quantity of shape (cases, 1), to go with positions."""
    if not batch_shape:  # spares a single design some microseconds
        return Layout(*(np.reshape(value, (1, 1)) for value in vars(layout).values()))
    return Layout(*(np.broadcast_to(value, batch_shape).reshape(-1, 1) for value in vars(layout).values()))


def common_normal(layout: Layout, axial: FloatArray | tuple[FloatArray, FloatArray]) -> CommonNormal:
    """Find the common normal of two flanks whose outward unit normals have the axial components
    `axial`, pinion first; the two may have shapes that broadcast.

    With n the pinion's normal, n.k1 = v1 and n.k2 = -v2 give n_y = -(v2 + v1 cos d)/sin d,
    written so that it stays exact for small d. `x_squared` is negative where no common
    normal exists."""
    both = axial[0] + axial[1]
    y = np.array([(layout.versed_angle * own - both) / layout.sin_angle for own in axial])
    return CommonNormal(1.0 - axial[0] * axial[0] - y[0] * y[0], y)


def parallel_normal(layout: Layout, axial: FloatArray, moment: FloatArray) -> CommonNormal:
    """Find the common normal on parallel axes of two flanks whose outward unit normals have the axial
    components `axial` and the moments `moment` about their axes, mm, pinion first.

    n.k1 = v1 and n.k2 = -v2 are one equation there, which asks for v1 + v2 = 0 and leaves n_y free; the
    moments g1, g2 of the line of action about both axes give it, E n_y = g1 + g2. NaN where v1 + v2 is
    more than MATCH."""
    y = (moment[0] + moment[1]) / layout.offset
    y = np.where(np.abs(axial[0] + axial[1]) <= MATCH, y, np.nan)
    return CommonNormal(1.0 - axial[0] * axial[0] - y * y, np.array((y, y)))


def normal_of_unmodified(layout: Layout, axial: FloatArray, moment: FloatArray) -> CommonNormal:
    """Find the common normal of unmodified flanks: `parallel_normal` where axes are parallel, elsewhere
    `common_normal`."""
    crossed, parallel = common_normal(layout, axial), layout.parallel
    if not parallel.any():
        return crossed
    own = parallel_normal(layout, axial, moment)
    return CommonNormal(
        np.where(parallel, own.x_squared, crossed.x_squared), np.where(parallel, own.y, crossed.y)
    )


def member_frame(
    layout: Layout, member: int, roll: ArrayLike, axial_position: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Find the rotation (..., 3, 3) and origin (..., 3) that carry a member's own frame to S_f:
    `x_f = rotation @ x_j + origin` (Eqs. 7-14). `member` is 0 for the pinion, 1 for the gear;
    `axial_position` is its mounting distance plus axial error, mm."""
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
    """Carry points (..., 3) of a member's own frame to S_f, mm (Eq. 7)."""
    rotation, origin = frame
    return np.asarray(np.einsum("...ij,...j->...i", rotation, points) + origin)


def normals_to_fixed(frame: tuple[FloatArray, FloatArray], normals: FloatArray) -> FloatArray:
    """Carry directions (..., 3) of a member's own frame to S_f (Eq. 8)."""
    return np.asarray(np.einsum("...ij,...j->...i", frame[0], normals))
