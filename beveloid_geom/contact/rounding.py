"""Sensitivity of a contact to rounding: the condition of the equations at a position.

A solved position satisfies the five equations to rounding. Where n_x is small along the entire path, where
the axes are nearly parallel, or where parabolas are weak, rounding of the inputs can still move the contact
by much more. This is a property of the pair, not of the method: an assembly error moves the contact by the
same factor.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .curves.curve_equations import linearised, units_of
from .flank_pair import is_modified, pairing_of
from .parallel.lines import is_line_contact
from .parallel.paths import along_lines
from .parallel.small_angle_equations import point_on_curve, regular_jacobian
from .parallel.small_angle_paths import nearly_parallel
from .path import ContactPath
from .surfaces.second_order import least_rates, least_singular_value


def rounding_error(path: ContactPath) -> FloatArray:
    """Return the distance by which rounding of the terms of the equations may move each contact.

    It is estimated from the least singular value of the Jacobian of the equations (`curve_equations`), within
    a factor of about ten.

    Parameters
    ----------
    path : ContactPath

    Returns
    -------
    ndarray, shape (..., positions)
        mm, perpendicular to the path; NaN where there is no contact, and on lines of contact.
    """
    if path.l1.size == 0:
        return np.empty(path.l1.shape)
    if is_modified(path.design, path.flank):
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = np.finfo(float).eps / least_rates(path)
        return np.asarray(np.where(is_line_contact(path.design, path.flank)[..., None], np.nan, moved))
    pairing = pairing_of(path.design, path.flank)
    units = units_of(pairing)
    shape = path.l1.shape
    l1, l2 = (np.reshape(x, (-1, shape[-1])) for x in (path.l1, path.l2))
    point, normal = (np.reshape(x, (-1, shape[-1], 3)) for x in (path.point, path.normal))
    regular = point_on_curve(point, normal, l1, l2)
    z = np.stack([regular[row] for row in (0, 1, 2, 4)], axis=-1) / units  # without n_y
    near = pairing.parallel | nearly_parallel(pairing)
    with np.errstate(divide="ignore", invalid="ignore"):
        least = least_singular_value(linearised(pairing, z, units)[1])
        if near.any():
            others = least_singular_value(regular_jacobian(pairing, regular)[1])
            least = np.where(near[:, None], others, least)
        known = np.isfinite(least) & ~along_lines(pairing)[:, None]
        moved = np.finfo(float).eps * units[..., 3] / least
    return np.asarray(np.where(known, moved, np.nan).reshape(shape))
