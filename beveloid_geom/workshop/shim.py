"""The inverse of mounting: which axial positions give the backlash wanted in a housing as it was measured.

Offset and shaft angle are those of the housing; the pinion is moved by P and the gear by G along their axes,
each towards its heel. One condition is the least normal backlash over a mesh cycle, j(P, G) = j_w. The other
is that the middle of the path of contact, its place at mid-roll, is at a share of the pinion's face,
z(P, G) = z_w; or, where no place is wanted, that both are moved no further than they must,

    P dj/dG - G dj/dP = 0,

the least of P^2 + G^2. Derivatives are exact (`backlash_by_errors`, `path_sensitivity`), the root is SciPy's.
Of flanks without parabolas j is linear in both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from ..analysis.place import limits_of
from ..analysis.sensitivity import path_sensitivity
from ..arrays import FloatArray, flank_sign
from ..contact.path import path_of_contact
from ..design.model import Design
from ..operation.backlash import backlash_by_errors, mounted_backlash
from ..pair.errors import ERROR_NAMES, mounted
from ..pair.mounting import mounting_of
from ..status import ShimStatus, Status
from ..support.few_lines import few_lines

BY = ("pinion_axial", "gear_axial")
COLUMNS = [ERROR_NAMES.index(name) for name in BY]
CLOSE = 1e-9
"""mm within which backlash and place are what is wanted."""
NO_EFFECT = 1e-9
"""mm of backlash a mm below which an axial position has none to give."""

GRID = 41
"""Even positions of either member at which a path is looked for, to start from."""

Function: TypeAlias = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Shim:
    """Axial positions of a `design` that give the normal backlash `wanted_backlash` (mm), and, unless
    `wanted_z` is NaN, put the middle of the path on `flank` there on the pinion, mm from mid-face.

    `axial` (2,): by how much pinion and gear are moved, mm, towards the heel, from where the design has them;
    `distance` (2,): their mounting distances then. What follows is of the mounting so found, solved anew:
    `backlash`, `z` (mm) and `contact_ratio`, NaN without a path; `residual`, mm, of all that was wanted.
    NaN, all, unless `status` is REACHED or OUT_OF_REACH, where it is more than `limit` (mm)."""

    __repr__ = few_lines

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
    """Find the axial positions of both members that give a backlash, in a pair as its errors have it.

    Parameters
    ----------
    design : Design
        A single one; offset and shaft angle measured are its errors.
    backlash : float
        Least normal backlash over a mesh cycle, mm.
    at : float, optional
        Share of the pinion's face from the toe at which the path's middle is wanted, above 0 and below 1;
        without it both members are moved as little as can be.
    flank : {'right', 'left'}
        Whose path.

    Returns
    -------
    Shim

    Raises
    ------
    ValueError
        For a batch, a share that is none, and where a tool's rounds overlap.
    """
    flank_sign(flank)
    if design.batch_shape:
        raise ValueError("shims are found of a single design: give its cases one by one")
    if at is not None and not 0.0 < at < 1.0:
        raise ValueError(f"at must be a share of the face above 0 and below 1, got {at:g}")
    z = np.nan if at is None else float(design.pinion.face_width) * (at - 0.5)
    limit = float(limits_of(design, BY).min())
    if np.abs(backlash_by_errors(design)[COLUMNS]).max() < NO_EFFECT:
        return _forward(design, flank, backlash, z, limit, None, ShimStatus.NO_EFFECT)
    off, by = _conditions(design, flank, backlash, z)
    found = _forward(design, flank, backlash, z, limit, _root(off, by, np.zeros(2)), ShimStatus.REACHED)
    if not found.residual <= CLOSE and at is not None:
        start = _start(design, flank, backlash, z, limit)
        if np.isnan(_middle(mounted(design, start, BY), flank)):
            return _forward(design, flank, backlash, z, limit, None, ShimStatus.NO_PATH)
        found = _forward(design, flank, backlash, z, limit, _root(off, by, start), ShimStatus.REACHED)
    if not found.residual <= CLOSE:
        return _forward(design, flank, backlash, z, limit, None, ShimStatus.NOT_FOUND)
    far = np.abs(found.axial).max() > limit
    return replace(found, status=ShimStatus.OUT_OF_REACH) if far else found


def _conditions(design: Design, flank: str, backlash: float, z: float) -> tuple[Function, Function]:
    """Give both conditions (2,), mm, of axial positions (2,), mm, and their derivatives (2, 2)."""

    def off(axial: FloatArray) -> FloatArray:
        """Give by how much the conditions are not met."""
        at = mounted(design, axial, BY)
        first = float(mounted_backlash(at).normal) - backlash
        if np.isnan(z):
            pinion, gear = backlash_by_errors(at)[COLUMNS]
            return np.array((first, axial[0] * gear - axial[1] * pinion))
        return np.array((first, _middle(at, flank) - z))

    def by(axial: FloatArray) -> FloatArray:
        """Give the derivatives; those of the second without what the first's change by."""
        at = mounted(design, axial, BY)
        pinion, gear = backlash_by_errors(at)[COLUMNS]
        second = (gear, -pinion) if np.isnan(z) else path_sensitivity(at, flank).z_by[1, 0, COLUMNS]
        return np.array(((pinion, gear), second))

    return off, by


def _middle(design: Design, flank: str) -> float:
    """Give z (mm) on the pinion of the middle of a path, NaN without one."""
    path = path_of_contact(design, flank, 3)
    return float(path.pinion_z[1]) if path.ends.status == Status.SOLVED else np.nan


def _start(design: Design, flank: str, backlash: float, z: float, limit: float) -> FloatArray:
    """Give axial positions (2,), mm, to start from: of a grid within the limit those with a path that come
    nearest to both conditions, the backlash taken as linear, or left out where that of the design is lost."""
    steps, by = limit * np.linspace(-1.0, 1.0, GRID), backlash_by_errors(design)[COLUMNS]
    axial = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    path = path_of_contact(mounted(design, axial, BY), flank, 3)
    play = float(mounted_backlash(design).normal) + axial @ by - backlash
    far = np.abs(path.pinion_z[:, 1] - z) + np.nan_to_num(np.abs(play) / np.abs(by).max())
    return np.asarray(axial[np.argmin(np.where(path.ends.status == Status.SOLVED, far, np.inf))])


def _root(off: Function, by: Function, start: FloatArray) -> FloatArray:
    """Find axial positions (2,), mm, that meet both conditions; where there are none, what SciPy ends at."""
    from scipy import optimize

    root: Any = optimize.root
    return np.asarray(root(off, start, jac=by, method="hybr", options={"xtol": 1e-13}).x)


def _forward(
    design: Design,
    flank: str,
    backlash: float,
    z: float,
    limit: float,
    axial: FloatArray | None,
    status: ShimStatus,
) -> Shim:
    """Solve the mounting found anew; without one all is NaN."""
    if axial is None:
        none, nan = np.full(2, np.nan), np.nan
        return Shim(design, flank, backlash, z, limit, none, none, nan, nan, nan, nan, status)
    at = mounted(design, axial, BY)
    errors = np.array([at.errors.pinion_axial, at.errors.gear_axial])
    found, middle = float(mounted_backlash(at).normal), _middle(at, flank)
    apart = [found - backlash] if np.isnan(z) else [found - backlash, middle - z]
    ratio = float(path_of_contact(at, flank, 2).ends.contact_ratio)
    return Shim(
        design=design,
        flank=flank,
        wanted_backlash=backlash,
        wanted_z=z,
        limit=limit,
        axial=axial,
        distance=mounting_of(design).distance + errors,
        backlash=found,
        z=middle,
        contact_ratio=ratio,
        residual=float(np.abs(apart).max()),
        status=status,
    )
