"""How far rounding moves a contact: the condition of the equations at a position.

A solved position satisfies the five equations to rounding. That is not yet a position that rounding
leaves where it is: where n_x is small all along a path, or the axes are nearly parallel, the last
digit of an angle moves the contact by much more. It is the pair that is so sensitive, not the method:
an error of mounting moves it by as many times more as it is greater than rounding.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .curve_equations import linearised, units_of
from .equation import pairing_of
from .parallel.lines import along_lines
from .parallel.nearly import nearly_parallel
from .parallel.regular import regular_jacobian
from .path import ContactPath


def rounding_error(path: ContactPath) -> FloatArray:
    """Give the distance (*batch, positions), mm, by which rounding in the terms of the equations may move
    each contact of a `path`, square to the path; NaN where there is none, and on lines of contact.

    From the least singular value of the equations' Jacobian (`curve_equations`), an estimate within a factor
    of some ten."""
    if path.l1.size == 0:
        return np.empty(path.l1.shape)
    pairing = pairing_of(path.design, path.flank)
    units = units_of(pairing)
    shape = path.l1.shape
    l1, l2, n_x = (np.reshape(x, (-1, shape[-1])) for x in (path.l1, path.l2, path.normal[..., 0]))
    point, normal = (np.reshape(x, (-1, shape[-1], 3)) for x in (path.point, path.normal))
    # w1 of the point: its coordinate along (k1 - v1 n) / S1.
    v = normal[..., 2]
    across = (point[..., 2] - v * np.einsum("...i,...i", point, normal)) / np.sqrt(1.0 - v * v)
    z = np.stack((l1, l2, n_x, across), axis=-1) / units
    near = pairing.parallel | nearly_parallel(pairing)
    with np.errstate(divide="ignore", invalid="ignore"):
        least = _least_rate(linearised(pairing, z, units)[1])
        if near.any():
            regular = np.stack((l1, l2, n_x, normal[..., 1], across))
            least = np.where(near[:, None], _least_rate(regular_jacobian(pairing, regular)[1]), least)
        known = np.isfinite(least) & ~along_lines(pairing)[:, None]
        moved = np.finfo(float).eps * units[..., 3] / least
    return np.asarray(np.where(known, moved, np.nan).reshape(shape))


def _least_rate(jacobian: FloatArray) -> FloatArray:
    """Give the least singular value of Jacobians (..., equations, unknowns), NaN where these are not
    known."""
    known = np.asarray(np.isfinite(jacobian).all(axis=(-1, -2)))
    least = np.linalg.svd(np.where(known[..., None, None], jacobian, 0.0), compute_uv=False)[..., -1]
    return np.where(known, least, np.nan)
