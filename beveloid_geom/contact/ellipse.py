"""Flanks to second order: normal derivatives, relative curvature, contact ellipses.

Relative curvature. With n1 the pinion's outward normal and A_j the map of a step in the tangent
plane to the change of the member's own outward normal (dn_j = A_j dR), the separation near a
contact is y.(A_1 + A_2) y / 2 along the common normal: positive curvature is clearance. A_j comes
from the derivatives of the normal, which turns with phi and, on a parabola, along d:

    n_l = Rz(phi) (n' + phi_l k x n),    n_u = phi_u k x n,    n' = -2 a T / (1 + 4 a^2 l^2)^(3/2),

T = d + 2 a l m. Without parabola n' vanishes; both flanks are developable, and the determinant
of A_1 + A_2 is the product of their curvatures and of the squared sine of the angle at which their
generators cross.

The contact ellipse for a separation s has the semi-axes sqrt(2 s / kappa). The paper has none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..design.model import Member
from ..gear.flank import flank_patch, turned
from ..gear.rack import rack_normal, rack_of, rack_point, rack_tangent
from ..pair.frames import layout_by_case, layout_of, member_frame, normals_to_fixed
from ..status import EllipseStatus
from ..support.few_lines import few_lines
from .equation import pairing_of
from .path import ContactPath

MARKING_SEPARATION = 0.00635
"""mm: thickness of the marking compound for which contact patterns are usually drawn."""
FLAT = 1e-9
"""Ratio of the principal curvatures below which the smaller one is rounding."""


@dataclass(frozen=True, eq=False)
class RelativeCurvature:
    """Relative curvature at contacts. `curvature` (..., 2), 1/mm, smaller first, positive where the
    flanks part; `direction` (..., 2, 3): its unit directions in S_f, square to the common normal."""

    curvature: FloatArray
    direction: FloatArray


@dataclass(frozen=True, eq=False)
class ContactEllipse:
    """Where the flanks stand closer than `separation` (mm) around contacts. `semi_axes` (..., 2),
    mm, major first; `direction` (..., 2, 3) in S_f; `curvature` (..., 2), 1/mm, smaller first, so that
    it goes with the axes; `status`: codes of `EllipseStatus`. NaN where there is no such axis."""

    __repr__ = few_lines

    separation: float
    semi_axes: FloatArray
    direction: FloatArray
    curvature: FloatArray
    status: NDArray[np.int8]


def normal_rates(member: Member, flank: str, l: ArrayLike, u: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Give derivatives (..., 3), 1/mm, of a flank's unit normal by its parameters l and u (mm), in the
    member's own frame. Analytic, as the tangents of `flank_patch`."""
    rack = rack_of(member, flank)
    l, u = np.broadcast_arrays(np.asarray(l, dtype=float), np.asarray(u, dtype=float))
    n, along, start = rack_normal(rack, l), rack_tangent(rack, l), rack_point(rack, l)
    bent = -2.0 * rack.parabola / (1.0 + (2.0 * rack.parabola * l) ** 2) ** 1.5 * along  # n'
    slope = n[1] / n[0]
    x, y = start[0] + u * rack.trace[0], start[1] + u * rack.trace[1]
    slope_l = (bent[1] - slope * bent[0]) / n[0]
    phi_l = (along[1] - slope * along[0] - slope_l * x) / rack.pitch_radius
    phi_u = (rack.trace[1] - slope * rack.trace[0]) / rack.pitch_radius
    phi = (y - slope * x) / rack.pitch_radius  # Eq. (6), last line
    by_l = turned(phi, bent[0] - phi_l * n[1], bent[1] + phi_l * n[0], bent[2])
    return by_l, turned(phi, -phi_u * n[1], phi_u * n[0], 0.0 * phi)


def relative_curvature(path: ContactPath) -> RelativeCurvature:
    """Give principal relative curvatures and directions at the positions of a path."""
    shape, basis = path.l1.shape, _tangent_basis(path.normal.reshape(-1, 3))
    pinion, gear = (_normal_map(*both, basis) for both in steps_and_turns(path))
    total = 0.5 * (pinion + gear + np.swapaxes(pinion + gear, -1, -2))
    known = np.isfinite(total.sum(axis=(1, 2)))
    curvature, vectors = np.linalg.eigh(np.where(known[:, None, None], total, 0.0))
    direction = np.einsum("nab,nai->nbi", vectors, basis)
    curvature[~known], direction[~known] = np.nan, np.nan
    return RelativeCurvature(curvature.reshape(*shape, 2), direction.reshape(*shape, 2, 3))


def contact_ellipse(path: ContactPath, separation: float = MARKING_SEPARATION) -> ContactEllipse:
    """Give contact ellipses at the positions of a path, for a `separation` in mm.

    Raises ValueError for a separation that is not positive. The ellipse is that of the second
    order: in approximate line contact it can reach past the flank, or further than that order
    holds; `pattern` has the separation itself."""
    return ellipse_of(relative_curvature(path), separation)


def ellipse_of(relative: RelativeCurvature, separation: float) -> ContactEllipse:
    """Give contact ellipses of a relative curvature; see `contact_ellipse`."""
    if not 0.0 < separation < np.inf:
        raise ValueError(f"separation must be a positive length in mm, got {separation:g}")
    curvature = relative.curvature
    least, greatest = np.moveaxis(curvature, -1, 0)
    rounding = FLAT * np.maximum(np.abs(least), np.abs(greatest))
    status = np.full(least.shape, np.int8(EllipseStatus.ELLIPSE))
    status[np.abs(least) <= rounding] = EllipseStatus.LINE_CONTACT
    status[least < -rounding] = EllipseStatus.INTERFERENCE
    status[np.isnan(least)] = EllipseStatus.NO_CONTACT
    kept = np.stack((least > rounding, greatest > rounding), axis=-1)
    axes = np.sqrt(2.0 * separation / np.where(kept, curvature, np.nan))
    return ContactEllipse(separation, axes, relative.direction, curvature, status)


def steps_and_turns(path: ContactPath) -> tuple[tuple[FloatArray, FloatArray], ...]:
    """Give tangents (n, 3, 2) by l and u for pinion and gear at n contacts, in S_f, and the derivatives
    (n, 3, 2) of the unit normal."""
    design = path.design
    cases, members = max(1, int(np.prod(path.l1.shape[:-1]))), design.stacked_members()
    l, u, roll = (
        np.stack([np.reshape(a, (cases, -1)) for a in pair])
        for pair in ((path.l1, path.l2), (path.u1, path.u2), (path.pinion_roll, path.gear_roll))
    )
    patch = flank_patch(members, path.flank, l, u)
    pairs = (patch.tangent_l, patch.tangent_u), normal_rates(members, path.flank, l, u)
    layout = layout_by_case(layout_of(design), design.batch_shape)
    position = pairing_of(design, path.flank).position
    frames = [member_frame(layout, j, roll[j], position[j]) for j in (0, 1)]

    def fixed(pair: tuple[FloatArray, FloatArray], j: int) -> FloatArray:
        return np.stack([normals_to_fixed(frames[j], vector[j]).reshape(-1, 3) for vector in pair], axis=-1)

    return tuple((fixed(pairs[0], j), fixed(pairs[1], j)) for j in (0, 1))


def _tangent_basis(normal: FloatArray) -> FloatArray:
    """Give unit vectors (n, 2, 3) square to the normals (n, 3): the first as near to z as can be."""
    first = np.array((0.0, 0.0, 1.0)) - normal[:, 2:] * normal
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack((first, np.cross(normal, first)), axis=1)


def _normal_map(steps: FloatArray, turns: FloatArray, basis: FloatArray) -> FloatArray:
    """Give A (n, 2, 2), 1/mm, by components on the basis."""
    (a, b), (c, d) = np.moveaxis(basis @ steps, 0, -1)
    inverse = np.array(((d, -b), (-c, a))) / (a * d - b * c)
    return np.asarray(basis @ turns @ np.moveaxis(inverse, -1, 0))
