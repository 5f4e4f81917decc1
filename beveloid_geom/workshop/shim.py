"""Axial positions of pinion and gear that give a required backlash in a measured housing.

Offset and shaft angle are those of the housing. The pinion is moved by P and the gear by G along their axes,
positive towards +z. The first condition is the smallest normal backlash over a mesh cycle, j(P, G) = j_w. The
second condition is the position of the middle of the path of contact on the pinion, z(P, G) = z_w. If no
position is required, it is the smallest movement, the minimum of P^2 + G^2,

    P dj/dG - G dj/dP = 0.

SciPy finds the root. The derivatives of j and z are exact (`backlash_by_errors`, `path_sensitivity`). Those
of the condition of smallest movement neglect the second derivatives of j. For flanks without parabolas, j is
linear in P and G. If the search does not converge, for example at a kink of the backlash, and no position is
required, the backlash is bracketed along one direction. The movement may then not be the smallest one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from ..analysis.path_placement import search_limits
from ..analysis.sensitivity import path_sensitivity
from ..arrays import FloatArray, flank_sign
from ..contact.path import path_of_contact
from ..design.arguments import require_numbers, require_single
from ..design.model import Design
from ..operation.backlash import backlash_by_errors, mounted_backlash
from ..pair.misalignment import ERROR_NAMES, mounted
from ..pair.mounting import mounting_of
from ..status import ShimStatus, Status
from ..support.array_repr import short_repr

BY = ("pinion_axial", "gear_axial")
COLUMNS = [ERROR_NAMES.index(name) for name in BY]
RESIDUAL_TOLERANCE_MM = 1e-9
"""Largest deviation from the required backlash and position."""

Function: TypeAlias = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Shim:
    """Axial positions that give a required backlash.

    Attributes
    ----------
    design : Design
    flank : str
        Flank of the path of contact.
    wanted_backlash : float
        Required normal backlash, mm.
    wanted_z : float
        Required position of the middle of the path on the pinion, mm from mid-face; NaN if none is required.
    limit : float
        Largest displacement that is allowed, mm.
    axial : array (2,)
        Displacements of pinion and gear from the positions of the design, mm, positive towards +z.
    distance : array (2,)
        Mounting distances after the displacements, mm.
    backlash, z, contact_ratio : float
        Backlash (mm), position of the middle of the path (mm) and contact ratio, computed for the new
        mounting. Without a path on the flanks, `z` is NaN and `contact_ratio` is 0.
    residual : float
        Largest deviation from the requirements, mm.
    status : ShimStatus
        Values are NaN unless the status is REACHED, or OUT_OF_REACH (a displacement is larger than the
        limit).
    """

    __repr__ = short_repr

    design: Design
    flank: str
    wanted_backlash: float
    wanted_z: float
    limit: float
    axial: FloatArray
    distance: FloatArray
    backlash: float
    z: float
    contact_ratio: float
    residual: float
    status: ShimStatus


def shim(design: Design, backlash: float, at: float | None = None, flank: str = "right") -> Shim:
    """Compute the axial positions of both members that give a backlash.

    Parameters
    ----------
    design : Design
        A single design. Its errors contain the measured offset and shaft angle.
    backlash : float
        Smallest normal backlash over a mesh cycle, mm.
    at : float, optional
        Required position of the middle of the path as a share of the face of the pinion from -z, above 0 and
        below 1. If omitted, the displacements are as small as possible.
    flank : {'right', 'left'}
        Flank of the path.

    Returns
    -------
    Shim

    Raises
    ------
    ValueError
        For a batch of designs, a backlash that is not finite, a share outside its limits, and tip rounds of a
        tool that overlap.

    References
    ----------
    Conditions: beveloid_geom/workshop/README.md, Shims.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> result = bg.shim(bg.builtin_design("ni-2017"), backlash=0.1)
    >>> result.status.name, result.axial.round(3)
    ('REACHED', array([1.523, 0.406]))
    """
    # Change of the backlash per mm of axial position (mm/mm) below which shims have no effect.
    min_backlash_slope = 1e-9
    require_single(design)
    flank_sign(flank)
    require_numbers(backlash=backlash, at=at)
    if not np.isfinite(backlash):
        raise ValueError(f"backlash must be a finite number in mm, got {backlash:g}")
    if at is not None and not 0.0 < at < 1.0:
        raise ValueError(f"at must be a share of the face above 0 and below 1, got {at:g}")
    z = np.nan if at is None else float(design.pinion.face_width) * (at - 0.5)
    limit = float(search_limits(design, BY).min())
    if np.abs(backlash_by_errors(design)[COLUMNS]).max() < min_backlash_slope:
        return _forward(design, flank, backlash, z, limit, None, ShimStatus.NO_EFFECT)
    off, by = _conditions(design, flank, backlash, z)
    result = _forward(design, flank, backlash, z, limit, _root(off, by, np.zeros(2)), ShimStatus.REACHED)
    # At a kink of the backlash, Newton's method may not converge.
    if not result.residual <= RESIDUAL_TOLERANCE_MM and at is None:
        result = _bracketed_shim(design, flank, backlash, limit, (off, by))
    # The path may leave the flanks between the design and the solution.
    if not result.residual <= RESIDUAL_TOLERANCE_MM and at is not None:
        start = _start(design, flank, backlash, z, limit)
        if np.isnan(_middle(mounted(design, start, BY), flank)):
            return _forward(design, flank, backlash, z, limit, None, ShimStatus.NO_PATH)
        result = _forward(design, flank, backlash, z, limit, _root(off, by, start), ShimStatus.REACHED)
    if not result.residual <= RESIDUAL_TOLERANCE_MM:
        return _forward(design, flank, backlash, z, limit, None, ShimStatus.NOT_FOUND)
    far = np.abs(result.axial).max() > limit
    return replace(result, status=ShimStatus.OUT_OF_REACH) if far else result


def _conditions(design: Design, flank: str, backlash: float, z: float) -> tuple[Function, Function]:
    """Return functions of axial positions (2,), mm: both conditions (2,), mm, and their derivatives (2,
    2)."""

    def off(axial: FloatArray) -> FloatArray:
        """Return the deviations from the conditions."""
        at = mounted(design, axial, BY)
        first = float(mounted_backlash(at).normal) - backlash
        if np.isnan(z):
            pinion, gear = backlash_by_errors(at)[COLUMNS]
            return np.array((first, axial[0] * gear - axial[1] * pinion))
        return np.array((first, _middle(at, flank) - z))

    def by(axial: FloatArray) -> FloatArray:
        """Return the derivatives; those of the second condition neglect the change of the slopes of j."""
        at = mounted(design, axial, BY)
        pinion, gear = backlash_by_errors(at)[COLUMNS]
        second = (gear, -pinion) if np.isnan(z) else path_sensitivity(at, flank).z_by[1, 0, COLUMNS]
        return np.array(((pinion, gear), second))

    return off, by


def _middle(design: Design, flank: str) -> float:
    """Return z (mm) of the middle of a path on the pinion, NaN without a path."""
    path = path_of_contact(design, flank, 3)
    return float(path.pinion_z[1]) if path.ends.status == Status.SOLVED else np.nan


def _start(design: Design, flank: str, backlash: float, z: float, limit: float) -> FloatArray:
    """Return axial positions (2,), mm, to start from: the positions of a grid within the limit that have a
    path and the smallest deviations from both conditions. The backlash is assumed to be linear, and is
    ignored if that of the design is unknown."""
    steps, by = limit * np.linspace(-1.0, 1.0, 41), backlash_by_errors(design)[COLUMNS]
    axial = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    path = path_of_contact(mounted(design, axial, BY), flank, 3)
    play = float(mounted_backlash(design).normal) + axial @ by - backlash
    far = np.abs(path.pinion_z[:, 1] - z) + np.nan_to_num(np.abs(play) / np.abs(by).max())
    return np.asarray(axial[np.argmin(np.where(path.ends.status == Status.SOLVED, far, np.inf))])


def _root(off: Function, by: Function, start: FloatArray) -> FloatArray:
    """Return axial positions (2,), mm, that meet both conditions, or the last ones of SciPy's iteration."""
    from scipy import optimize

    root: Any = optimize.root
    return np.asarray(root(off, start, jac=by, method="hybr", options={"xtol": 1e-13, "maxfev": 40}).x)


def _bracketed_shim(
    design: Design, flank: str, backlash: float, limit: float, conditions: tuple[Function, Function]
) -> Shim:
    """Return axial positions found by bracketing, or those of smallest movement if the search converges from
    there."""
    axial = _bracketed(design, backlash, limit)
    bracketed = _forward(design, flank, backlash, np.nan, limit, axial, ShimStatus.REACHED)
    if not bracketed.residual <= RESIDUAL_TOLERANCE_MM:
        return bracketed
    least = _forward(design, flank, backlash, np.nan, limit, _root(*conditions, axial), ShimStatus.REACHED)
    shorter = least.residual <= RESIDUAL_TOLERANCE_MM and np.linalg.norm(least.axial) < np.linalg.norm(axial)
    return least if shorter else bracketed


def _bracketed(design: Design, backlash: float, limit: float) -> FloatArray:
    """Return axial positions (2,), mm, that give the backlash, along its gradient at the design's positions.

    NaN if there are none within the limit. No derivatives are needed."""
    from scipy import optimize

    def off(distance: FloatArray) -> FloatArray:
        """Return backlash minus required backlash at distances (n,) along the direction, mm."""
        at = mounted(design, distance[:, None] * direction, BY)
        return np.asarray(mounted_backlash(at).normal - backlash)

    by = backlash_by_errors(design)[COLUMNS]
    now = float(mounted_backlash(design).normal) - backlash
    direction = -np.sign(now) * by / np.linalg.norm(by)
    if not np.isfinite(direction).all():
        return np.full(2, np.nan)
    distance = limit / np.abs(direction).max() * np.linspace(0.0, 1.0, 17)
    values = off(distance)
    change = np.flatnonzero((values[:-1] * now > 0.0) & (values[1:] * now <= 0.0))
    if not change.size:
        return np.full(2, np.nan)
    low, high = distance[change[0]], distance[change[0] + 1]
    return np.asarray(
        direction * optimize.toms748(lambda x: float(off(np.array([x]))[0]), low, high, xtol=1e-12)
    )


def _forward(
    design: Design,
    flank: str,
    backlash: float,
    z: float,
    limit: float,
    axial: FloatArray | None,
    status: ShimStatus,
) -> Shim:
    """Return the result for axial positions, computed for the new mounting; NaN without positions."""
    if axial is None or not np.isfinite(axial).all():
        none, nan = np.full(2, np.nan), np.nan
        return Shim(design, flank, backlash, z, limit, none, none, nan, nan, nan, nan, status)
    at = mounted(design, axial, BY)
    errors = np.array([at.errors.pinion_axial, at.errors.gear_axial])
    actual, middle = float(mounted_backlash(at).normal), _middle(at, flank)
    deviations = [actual - backlash] if np.isnan(z) else [actual - backlash, middle - z]
    ratio = float(path_of_contact(at, flank, 2).ends.contact_ratio)
    return Shim(
        design=design,
        flank=flank,
        wanted_backlash=backlash,
        wanted_z=z,
        limit=limit,
        axial=axial,
        distance=mounting_of(design).distance + errors,
        backlash=actual,
        z=middle,
        contact_ratio=ratio,
        residual=float(np.abs(deviations).max()),
        status=status,
    )
