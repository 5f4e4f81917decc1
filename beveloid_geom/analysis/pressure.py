"""Hertzian pressure along a path of contact.

At each position the flanks are loaded by a force F along the common normal n. F is given, or follows from a
torque T on the pinion, F = T / |n.(k1 x R)|, with the contact point R and the direction k1 of the pinion
axis. Without parabola, this lever is m_n N1 cos(alpha) / 2 everywhere; N1 is the pinion's number of teeth.
Relative curvatures and their directions are those of `contact.ellipse`, axes and pressure those of
`contact.hertz`. Both flanks have the same material. Friction, neighbouring tooth pairs and edges are
neglected.

Flanks in line contact (`contact.parallel`) carry F on all lines of this roll, because rigid flanks without
transmission error touch on several tooth pairs at the same time. F is distributed evenly, with a load per
length of q = F / (total length of the lines). The pressure is that of a strip, at the point of the line with
the largest relative curvature. For involutes, whose curvature 1/rho_1 + 1/rho_2 is convex along the line,
this is one of the ends of the line. The elastic deflection of the teeth, which changes this distribution, is
neglected.

If the ellipse extends beyond an edge of a flank, less material carries the force than in Hertz's theory, and
the pressure is higher. The positions of its four vertices are computed to first order of their distance: dl
and du of a step in the tangent plane, then z and radius (Eq. 6)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..arrays import Codes, FloatArray, Mask, flank_sign
from ..contact.ellipse import curvature_ellipse, relative_curvature, steps_and_turns
from ..contact.equation import edge_margins, limit_margins
from ..contact.flank_pair import is_modified
from ..contact.hertz import POISSON_RATIO, YOUNG_MPA, contact_modulus, hertz_ellipse, hertz_strip
from ..contact.parallel.lines import ContactLines, carrying_length, contact_lines, is_line_contact
from ..contact.path import ContactPath, pairing_of_path
from ..design.arguments import require_numbers, require_path
from ..gear.flank import flank_point
from ..status import EllipseStatus
from ..support.array_repr import short_repr
from .sliding import tooth_traces

NO_LIMIT_REACHED = -1
"""Code of an ellipse that exceeds no limit."""


@dataclass(frozen=True)
class Load:
    """Load on one tooth pair, or on all lines of contact together.

    Parameters
    ----------
    force : float, optional
        Force along the common normal, N.
    torque_nm : float, optional
        Torque on the pinion, N m.
    young : float
        Young's modulus of both members, MPa.
    poisson : float
        Poisson's ratio of both members.

    Raises
    ------
    ValueError
        Unless exactly one of force and torque is given, and for values outside their limits.
    """

    force: float | None = None
    torque_nm: float | None = None
    young: float = YOUNG_MPA
    poisson: float = POISSON_RATIO

    def __post_init__(self) -> None:
        """Check the values. Raises TypeError or ValueError."""
        require_numbers(**vars(self))
        if (self.force is None) == (self.torque_nm is None):
            raise ValueError("a load is either a force or a torque on the pinion: give one of them")
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
    """Hertzian ellipses or strips under a `load` at the positions of a `path`; NaN where there is none.

    Attributes
    ----------
    force, pressure : FloatArray
        (..., positions), force along the normal, N, and largest pressure, MPa.
    semi_axes : FloatArray
        (..., 2), mm, major axis first. In line contact (LINE_CONTACT): half the length of the line and half
        the width of the strip.
    direction : FloatArray
        (..., 2, 3), unit directions of both semi-axes in the fixed frame S_f (`pair.frames`).
    angle : FloatArray
        Angle of the major axis to the pinion tooth trace, rad, -pi/2 to pi/2; positive if the end of the axis
        that points to the heel is closer to the tip.
    curvature : FloatArray
        (..., 2), principal relative curvatures, 1/mm, smaller first. In line contact, curvature, width and
        pressure are those at the point of the line with the largest pressure; the pressure is NaN if the
        lines have no length.
    reaches : Codes
        Codes of the `Limit` that the ellipse exceeds most, NO_LIMIT_REACHED if it exceeds none. If it exceeds
        one, the true pressure is higher.
    status : Codes
        Codes of `EllipseStatus`.
    total_length : FloatArray
        Total length of the lines that share the force, mm; NaN for an ellipse.
    """

    __repr__ = short_repr

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
    total_length: FloatArray


def path_pressure(path: ContactPath, load: Load) -> PathPressure:
    """Compute the Hertzian ellipse, or the strip of a line contact, and the pressure at the positions of a
    path.

    Parameters
    ----------
    path : ContactPath
    load : Load

    Returns
    -------
    PathPressure
        If the contact is an ellipse, one tooth pair carries the load; in line contact, all lines carry it
        together. NaN on crossed axes if the contact is a line to rounding (LINE_CONTACT), and if the flanks
        intersect near the contact (INTERFERENCE).

    References
    ----------
    Hertzian contact: beveloid_geom/analysis/README.md, Pressure.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> path = bg.path_of_contact(bg.builtin_design("ni-2017"), points=3)
    >>> bg.path_pressure(path, bg.Load(force=100.0)).pressure.round(1)  # MPa
    array([152.3, 137.7, 138.7])
    """
    require_path(path)
    lines = contact_lines(path) if is_line_contact(path.design, path.flank).any() else None
    along = np.zeros(path.l1.shape, dtype=bool) if lines is None else np.isfinite(lines.length)
    relative, modulus = relative_curvature(path), contact_modulus(load.young, load.poisson)
    status = curvature_ellipse(relative, 1.0).status
    elliptical = (status == EllipseStatus.ELLIPSE) & ~along
    (x, y, _), (nx, ny, _) = np.moveaxis(path.point, -1, 0), np.moveaxis(path.normal, -1, 0)
    lever = np.abs(x * ny - y * nx)  # n.(k1 x R)
    force = load.force + 0.0 * lever if load.torque_nm is None else 1e3 * load.torque_nm / lever
    curvature = np.where(elliptical[..., None], relative.curvature, np.nan)
    ellipse = hertz_ellipse(curvature, force, modulus)
    pressed = PathPressure(
        path=path,
        load=load,
        force=ellipse.force,
        pressure=ellipse.pressure,
        semi_axes=ellipse.semi_axes,
        direction=relative.direction,
        angle=np.where(elliptical | along, _angle(path, relative.direction[..., 0, :]), np.nan),
        curvature=relative.curvature,
        reaches=_reaches(path, ellipse.semi_axes[..., None] * relative.direction),
        status=status,
        total_length=np.full(status.shape, np.nan),
    )
    if lines is None or not along.any():
        return pressed
    return _along_lines(pressed, lines, along, modulus)


def _along_lines(given: PathPressure, lines: ContactLines, along: Mask, modulus: float) -> PathPressure:
    """Return the pressures with strips at the positions `along` where flanks touch along lines."""
    path = given.path
    greatest = _curvature_at_ends(lines, path).max(axis=-1)
    if not is_modified(path.design, path.flank):  # the path may run along the beginning of a relief
        greatest = np.fmax(greatest, given.curvature[..., 1])
    total = np.where(along, carrying_length(path, lines), np.nan)
    with np.errstate(divide="ignore"):
        half_width, pressure = hertz_strip(greatest, given.force / total, modulus)
    strip = np.stack((0.5 * lines.length, half_width), axis=-1)
    across = np.stack((np.zeros_like(greatest), greatest), axis=-1)
    return replace(
        given,
        pressure=np.where(along, pressure, given.pressure),
        semi_axes=np.where(along[..., None], strip, given.semi_axes),
        curvature=np.where(along[..., None], across, given.curvature),
        status=np.where(along, np.int8(EllipseStatus.LINE_CONTACT), given.status),
        total_length=total,
    )


def _curvature_at_ends(lines: ContactLines, path: ContactPath) -> FloatArray:
    """Return the greater relative curvature (..., positions, 2), 1/mm, at both ends of the lines."""
    # Distance of the points from the ends, as a fraction of the line: a relief can begin at an end, and its
    # curvature does not belong to the line.
    inset = 1e-9 if is_modified(path.design, path.flank) else 0.0
    shape, values = lines.l1.shape, dict[str, Any]()
    for name in ("l1", "u1", "l2", "u2", "pinion_z", "gear_z"):
        ends = getattr(lines, name)
        values[name] = (ends + inset * (ends[..., ::-1] - ends)).reshape(*shape[:-2], -1)
    for name in ("pinion_roll", "gear_roll"):
        values[name] = np.repeat(getattr(path, name), 2, axis=-1)
    values["normal"] = np.repeat(path.normal, 2, axis=-2)
    return np.asarray(relative_curvature(replace(path, **values)).curvature[..., 1].reshape(shape))


def _angle(path: ContactPath, major: FloatArray) -> FloatArray:
    """Return the angle (rad) of directions to the pinion tooth trace, positive towards the tip."""
    trace = tooth_traces(path)[..., 0, :].reshape(major.shape)
    upward = flank_sign(path.flank) * np.cross(path.normal, trace)
    along, up = (np.einsum("...i,...i", major, axis) for axis in (trace, upward))
    return np.asarray(np.arctan2(np.where(along < 0.0, -up, up), np.abs(along)))


def _reaches(path: ContactPath, axes: FloatArray) -> Codes:
    """Return the limits that the vertices of ellipses with semi-axes (..., 2, 3), in S_f, mm, exceed most."""
    design, shape = path.design, path.l1.shape
    cases = max(1, int(np.prod(shape[:-1])))
    ends = np.concatenate((axes, -axes), axis=-2).reshape(-1, 4, 3)
    both = ((path.l1, path.u1), (path.l2, path.u2))
    moved = np.empty((2, 2, len(ends), 4))  # l and u, member
    for member, ((tangents, _), parameters) in enumerate(zip(steps_and_turns(path), both, strict=True)):
        form = np.einsum("nia,nib->nab", tangents, tangents)
        (a, b), (_, c) = np.moveaxis(form, 0, -1)
        inverse = np.moveaxis(np.array(((c, -b), (-b, a))) / (a * c - b * b), -1, 0)
        step = np.einsum("nab,nib,nki->ank", inverse, tangents, ends)
        moved[:, member] = np.stack([values.reshape(-1, 1) for values in parameters]) + step
    l, u = moved.reshape(2, 2, cases, -1)
    x, y, z = np.moveaxis(flank_point(design.stacked_members(), path.flank, l, u), -1, 0)
    pairing = pairing_of_path(path)
    margins = limit_margins(pairing, l, z, np.hypot(x, y))
    if pairing.edges:
        margins[:2] = np.minimum(margins[:2], edge_margins(pairing, l, z))
    least = margins.reshape(8, *shape, 4).min(axis=-1)
    return np.where(least.min(axis=0) < 0.0, least.argmin(axis=0), NO_LIMIT_REACHED).astype(np.int8)
