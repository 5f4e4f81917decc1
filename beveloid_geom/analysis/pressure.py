"""Hertz's pressure along a path of contact: the ellipse in which one tooth pair touches under its load.

At each position the flanks touch under a force F along the common normal n, that given or, under a torque
T on the pinion, F = T / |n.(k1 x R)|: without parabola the lever is m_n N cos(alpha) / 2 all along. Relative
curvatures and their directions are those of `contact.ellipse`, axes and pressure those of `contact.hertz`:
flanks of one material, without friction, neighbouring tooth pairs or edges.

Where the ellipse ends beyond an edge of a flank, less metal carries the force than Hertz has, and the
pressure is greater than his. Where its four vertices stand is told by their flank parameters, to first order
of their distance: dl and du of a step in the tangent plane, then z and radius there (Eq. 6).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import Codes, FloatArray, flank_sign
from ..contact.ellipse import ellipse_of, relative_curvature, steps_and_turns
from ..contact.equation import limit_margins, pairing_of
from ..contact.hertz import POISSON, YOUNG, contact_modulus, hertz_ellipse
from ..contact.path import ContactPath
from ..gear.flank import flank_point
from ..status import EllipseStatus
from ..support.few_lines import few_lines
from .sliding import tooth_traces

WHOLE = -1
"""In place of a limit: the ellipse passes none."""


@dataclass(frozen=True)
class Load:
    """What one tooth pair carries: the `force` along the common normal, N, or the torque on the pinion,
    `torque_nm`, N m; with `young`, MPa, and `poisson` of both members.

    Raises ValueError for neither or both, and for values outside their limits."""

    force: float | None = None
    torque_nm: float | None = None
    young: float = YOUNG
    poisson: float = POISSON

    def __post_init__(self) -> None:
        """Raises ValueError as the class says."""
        if (self.force is None) == (self.torque_nm is None):
            raise ValueError("a load is a force or a torque on the pinion: give one of them")
        sizes = {
            "force": (self.force, "N"),
            "torque_nm": (self.torque_nm, "N m"),
            "young": (self.young, "MPa"),
        }
        for name, (value, unit) in sizes.items():
            if value is not None and not 0.0 < value < np.inf:
                raise ValueError(f"{name} must be a finite number above 0 {unit}, got {value:g}")
        if not 0.0 <= self.poisson <= 0.5:
            raise ValueError(f"poisson must be from 0 to 0.5, got {self.poisson:g}")


@dataclass(frozen=True, eq=False)
class PathPressure:
    """Hertz's ellipses under a `load` at the positions of a `path`; NaN where there is none.

    Arrays (*batch, positions): `force` along the normal, N; `pressure`, the greatest in the ellipse, MPa;
    `angle` (rad, -pi/2 to pi/2) of its major axis from the pinion's tooth trace, positive if the end towards
    the heel lies towards the tip; `reaches`, codes of the `Limit` that the ellipse passes by most, WHOLE
    where it passes none: of the others the pressure is too low; `status`, codes of `EllipseStatus`.
    `curvature` (..., 2), principal relative curvatures, 1/mm, smaller first; `semi_axes` (..., 2), mm, major
    first; `direction` (..., 2, 3): unit directions of both in S_f."""

    __repr__ = few_lines

    path: ContactPath = field(repr=False)
    load: Load
    force: FloatArray
    pressure: FloatArray
    semi_axes: FloatArray
    direction: FloatArray
    angle: FloatArray
    curvature: FloatArray
    reaches: Codes
    status: Codes


def pressure_along(path: ContactPath, load: Load) -> PathPressure:
    """Find ellipse and pressure of Hertz at the positions of a path, one tooth pair under the `load`.

    Parameters
    ----------
    path : ContactPath
    load : Load

    Returns
    -------
    PathPressure
        NaN in approximate line contact to rounding (LINE_CONTACT), and where the flanks cut each other
        beside the contact (INTERFERENCE); `status` says so.
    """
    relative = relative_curvature(path)
    status = ellipse_of(relative, 1.0).status
    kept = status == EllipseStatus.ELLIPSE
    (x, y, _), (nx, ny, _) = np.moveaxis(path.point, -1, 0), np.moveaxis(path.normal, -1, 0)
    lever = np.abs(x * ny - y * nx)  # n.(k1 x R)
    force = load.force + 0.0 * lever if load.torque_nm is None else 1e3 * load.torque_nm / lever
    curvature = np.where(kept[..., None], relative.curvature, np.nan)
    found = hertz_ellipse(curvature, force, contact_modulus(load.young, load.poisson))
    return PathPressure(
        path=path,
        load=load,
        force=found.force,
        pressure=found.pressure,
        semi_axes=found.semi_axes,
        direction=relative.direction,
        angle=np.where(kept, _angle(path, relative.direction[..., 0, :]), np.nan),
        curvature=relative.curvature,
        reaches=_reaches(path, found.semi_axes[..., None] * relative.direction),
        status=status,
    )


def _angle(path: ContactPath, major: FloatArray) -> FloatArray:
    """Find the angle (rad) of directions from the pinion's tooth trace towards its tip."""
    trace = tooth_traces(path)[..., 0, :].reshape(major.shape)
    upward = flank_sign(path.flank) * np.cross(path.normal, trace)
    along, up = (np.einsum("...i,...i", major, axis) for axis in (trace, upward))
    return np.asarray(np.arctan2(np.where(along < 0.0, -up, up), np.abs(along)))


def _reaches(path: ContactPath, axes: FloatArray) -> Codes:
    """Find which limit the vertices of ellipses with the semi-axes (..., 2, 3), S_f, mm, pass by most."""
    design, shape = path.design, path.l1.shape
    cases = max(1, int(np.prod(shape[:-1])))
    ends = np.concatenate((axes, -axes), axis=-2).reshape(-1, 4, 3)
    both = ((path.l1, path.u1), (path.l2, path.u2))
    moved = np.empty((2, 2, len(ends), 4))  # l and u, member
    for member, ((tangents, _), own) in enumerate(zip(steps_and_turns(path), both, strict=True)):
        form = np.einsum("nia,nib->nab", tangents, tangents)
        (a, b), (_, c) = np.moveaxis(form, 0, -1)
        inverse = np.moveaxis(np.array(((c, -b), (-b, a))) / (a * c - b * b), -1, 0)
        step = np.einsum("nab,nib,nki->ank", inverse, tangents, ends)
        moved[:, member] = np.stack([values.reshape(-1, 1) for values in own]) + step
    l, u = moved.reshape(2, 2, cases, -1)
    x, y, z = np.moveaxis(flank_point(design.stacked_members(), path.flank, l, u), -1, 0)
    margins = limit_margins(pairing_of(design, path.flank), l, z, np.hypot(x, y))
    least = margins.reshape(8, *shape, 4).min(axis=-1)
    return np.where(least.min(axis=0) < 0.0, least.argmin(axis=0), WHOLE).astype(np.int8)
