"""Second-order geometry of the flanks in contact: relative curvature and contact ellipses.

Let n1 be the outward normal of the pinion, and A_j the map from a step in the tangent plane to the change of
the outward normal of member j (dn_j = A_j dR). The separation near a contact is y.(A_1 + A_2) y / 2 along the
common normal: positive curvature is clearance. A_j follows from the derivatives of the normal. The normal
rotates with the generating roll phi (Eq. 6) and, on a parabola, also with l. With the rack vectors d along
the straight profile and m along its normal (`gear.rack`),

    n_l = Rz(phi) (n' + phi_l k x n),    n_u = phi_u k x n,    n' = -2 a T / (1 + 4 a^2 l^2)^(3/2),

T = d + 2 a l m. Without a parabola n' vanishes. Both flanks are then developable, and the determinant of
A_1 + A_2 is the product of their curvatures and of the squared sine of the angle between their generators.

The contact ellipse for a separation s has the semi-axes sqrt(2 s / kappa). The paper has none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray
from ..gear.flank import flank_patch, normal_rates
from ..pair.frames import layout_by_case, member_frame, normals_to_fixed
from ..status import EllipseStatus
from ..support.array_repr import short_repr
from .flank_pair import is_modified, pairing_of
from .path import ContactPath
from .surfaces.second_order import tangents_and_turns

MARKING_SEPARATION_MM = 0.00635
"""mm: thickness of the marking compound for which contact patterns are usually drawn."""


@dataclass(frozen=True, eq=False)
class RelativeCurvature:
    """Relative curvature at contacts.

    `curvature` (..., 2), 1/mm, smaller first, positive where the flanks separate; `direction` (..., 2, 3):
    its unit directions in S_f, perpendicular to the common normal.
    """

    curvature: FloatArray
    direction: FloatArray


@dataclass(frozen=True, eq=False)
class ContactEllipse:
    """Region around contacts in which the separation of the flanks is below `separation` (mm).

    `semi_axes` (..., 2), mm, major first; `direction` (..., 2, 3) in S_f; `curvature` (..., 2), 1/mm, smaller
    first, in the order of the axes; `status`: codes of `EllipseStatus`. NaN where there is no such axis.
    """

    __repr__ = short_repr

    separation: float
    semi_axes: FloatArray
    direction: FloatArray
    curvature: FloatArray
    status: Codes


def relative_curvature(path: ContactPath) -> RelativeCurvature:
    """Return principal relative curvatures and directions at the positions of a path."""
    shape, basis = path.l1.shape, _tangent_basis(path.normal.reshape(-1, 3))
    pinion, gear = (_normal_map(*both, basis) for both in steps_and_turns(path))
    total = 0.5 * (pinion + gear + np.swapaxes(pinion + gear, -1, -2))
    known = np.isfinite(total.sum(axis=(1, 2)))
    # Principal curvatures of the sum of both normal maps; zeros in place of NaN for LAPACK.
    curvature, vectors = np.linalg.eigh(np.where(known[:, None, None], total, 0.0))
    direction = np.einsum("nab,nai->nbi", vectors, basis)
    curvature[~known], direction[~known] = np.nan, np.nan
    return RelativeCurvature(curvature.reshape(*shape, 2), direction.reshape(*shape, 2, 3))


def contact_ellipse(path: ContactPath, separation: float = MARKING_SEPARATION_MM) -> ContactEllipse:
    """Return the contact ellipses at the positions of a path.

    Parameters
    ----------
    path : ContactPath
    separation : float
        Separation at the rim of the ellipse, mm.

    Returns
    -------
    ContactEllipse

    Raises
    ------
    ValueError
        For a separation that is not positive.

    Notes
    -----
    The ellipse is of second order. In approximate line contact it can reach beyond the flank, or beyond the
    range of this approximation; `contact_pattern` uses the exact separation.
    """
    return curvature_ellipse(relative_curvature(path), separation)


def curvature_ellipse(relative: RelativeCurvature, separation: float) -> ContactEllipse:
    """Return contact ellipses of a relative curvature; see `contact_ellipse`."""
    # Ratio of the principal curvatures below which the smaller one is dominated by rounding.
    flat_curvature_ratio = 1e-9
    if not 0.0 < separation < np.inf:
        raise ValueError(f"separation must be a positive length in mm, got {separation:g}")
    curvature = relative.curvature
    least, greatest = np.moveaxis(curvature, -1, 0)
    rounding = flat_curvature_ratio * np.maximum(np.abs(least), np.abs(greatest))
    status = np.full(least.shape, np.int8(EllipseStatus.ELLIPSE))
    status[np.abs(least) <= rounding] = EllipseStatus.LINE_CONTACT
    status[least < -rounding] = EllipseStatus.INTERFERENCE
    status[np.isnan(least)] = EllipseStatus.NO_CONTACT
    positive = np.stack((least > rounding, greatest > rounding), axis=-1)
    axes = np.sqrt(2.0 * separation / np.where(positive, curvature, np.nan))
    return ContactEllipse(separation, axes, relative.direction, curvature, status)


def steps_and_turns(path: ContactPath) -> tuple[tuple[FloatArray, FloatArray], ...]:
    """Return tangents (n, 3, 2) by l and u of pinion and gear at n contacts, in S_f, and the derivatives (n,
    3, 2) of the unit normal.
    """
    design = path.design
    if is_modified(design, path.flank):
        with np.errstate(invalid="ignore", divide="ignore"):
            return tangents_and_turns(path)
    cases, members = max(1, int(np.prod(path.l1.shape[:-1]))), design.stacked_members()
    l, u, roll = (
        np.stack([np.reshape(a, (cases, -1)) for a in pair])
        for pair in ((path.l1, path.l2), (path.u1, path.u2), (path.pinion_roll, path.gear_roll))
    )
    # Tangents and normal derivatives in the gear frames, then rotated to S_f.
    patch = flank_patch(members, path.flank, l, u)
    pairs = (patch.tangent_l, patch.tangent_u), normal_rates(members, path.flank, l, u)
    layout = layout_by_case(design)
    position = pairing_of(design, path.flank).position
    frames = [member_frame(layout, j, roll[j], position[j]) for j in (0, 1)]

    def fixed(pair: tuple[FloatArray, FloatArray], j: int) -> FloatArray:
        return np.stack([normals_to_fixed(frames[j], vector[j]).reshape(-1, 3) for vector in pair], axis=-1)

    return tuple((fixed(pairs[0], j), fixed(pairs[1], j)) for j in (0, 1))


def _tangent_basis(normal: FloatArray) -> FloatArray:
    """Return unit vectors (n, 2, 3) perpendicular to the normals (n, 3); the first is as close to z as
    possible.
    """
    first = np.array((0.0, 0.0, 1.0)) - normal[:, 2:] * normal
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack((first, np.cross(normal, first)), axis=1)


def _normal_map(steps: FloatArray, turns: FloatArray, basis: FloatArray) -> FloatArray:
    """Return A (n, 2, 2), 1/mm, by components in the basis."""
    (a, b), (c, d) = np.moveaxis(basis @ steps, 0, -1)
    inverse = np.array(((d, -b), (-c, a))) / (a * d - b * c)
    return np.asarray(basis @ turns @ np.moveaxis(inverse, -1, 0))
