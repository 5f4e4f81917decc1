"""Conversion between assembly errors at the mesh and about the common perpendicular.

`Errors` rotate and move the axes at their common perpendicular, which can be metres away from the teeth.
`MeshErrors` do so at the pitch point P of the layout without errors. The pinion is fixed, and the gear is
moved as a rigid body in S_f:

1. rotation by `in_plane` about x through P, in the plane parallel to both axes, that of the shaft angle;
2. rotation by `out_of_plane` about P, around the direction perpendicular to x and to the gear axis after
   step 1, so that k2 gains sin(out_of_plane) along +x;
3. translation by `centre_distance` along u, which points from the point of the pinion axis nearest to P to
   the point of the gear axis nearest to P; on parallel axes it increases the distance of the axes;
4. translation of each member along its axis by its axial error.

With the shaft angle d and its sense s, D = s (d + in_plane) and o = out_of_plane, the gear axis has the
direction k2' = (sin o, cos o sin D, cos o cos D) and passes through q = (E, 0, 0) + g, where g is the
displacement of the foot (E, 0, 0). The new common perpendicular has the direction x' = s (k2' x k1)/n with
n = |k2' x k1|. With y' = k1 x x' the errors about it are

    E' = q.x',   tan d' = n/(k2'.k1),   t = -q.y'/(s n),   z = q.k1 + t k2'.k1,

where t and z are the distances of the new feet from q and from the old foot on the pinion axis; axial
positions are counted from the feet. g is formed from differences, so that a distant pivot costs no digits.

These are five errors for the four degrees of freedom of two axes with a position on each. The inverse
conversion therefore keeps one of them fixed: the tilt out of the plane if u is within 60 deg of x, as on
ordinary crossed axes, where the centre distance then determines the offset; otherwise the centre distance,
which on intersecting axes is equivalent to two axial errors.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, TypeAlias, TypeVar

import numpy as np

from ..arrays import COMPLEX_STEP, FloatArray, Mask, Quantity
from ..design.member import unchecked
from ..design.model import Design, Errors, MeshErrors
from .frames import layout_of
from .mounting import mounting_of

Kind = TypeVar("Kind", Errors, MeshErrors)
Complex: TypeAlias = np.ndarray[Any, np.dtype[Any]]
"""Values that may be complex; their imaginary parts give derivatives."""


@dataclass(frozen=True, eq=False)
class _Nominal:
    """Layout without errors.

    `offset` E, mm; `sense` of the design, s; signed shaft `angle` s d, rad, and its `sign` (on parallel axes,
    the sign of the rotation); `arm`, mm: the foot (E, 0, 0) seen from the pitch point, by components along
    x, k2 and k2 x x; `centre_line`: the unit vector u, by components in S_f.
    """

    offset: FloatArray
    sense: FloatArray
    angle: FloatArray
    sign: FloatArray
    arm: FloatArray
    centre_line: FloatArray


@dataclass(frozen=True, eq=False)
class _Turned:
    """Axes after both rotations: `moved` is g, `x` and `y` are the x and y components of x' and y', `normal`
    is n, and `along` is k2'.k1.
    """

    moved: FloatArray
    x: tuple[FloatArray, FloatArray]
    y: tuple[FloatArray, FloatArray]
    normal: FloatArray
    along: FloatArray


def _nominal(design: Design, lean: Any = 0.0) -> _Nominal:
    """Return the layout of a design; the sign of parallel axes is that of their rotation `lean`."""
    bare = design.with_errors(Errors())
    layout, mounting = layout_of(bare, with_errors=False), mounting_of(bare)
    sin, cos = layout.sin_angle, layout.cos_angle
    x, y, z = np.moveaxis(mounting.pitch_point, -1, 0)
    first, second = mounting.pitch_distance
    between = np.broadcast_arrays(layout.offset + 0.0 * first, sin * second, cos * second - first)
    with np.errstate(invalid="ignore"):
        line = np.stack(between) / np.sqrt(sum(part * part for part in between))
    return _Nominal(
        offset=np.asarray(layout.offset, dtype=float),
        sense=design.sense,
        angle=np.asarray(layout.shaft_angle, dtype=float),
        sign=np.where(np.where(layout.parallel, lean, layout.shaft_angle) < 0.0, -1.0, 1.0),
        arm=np.stack(np.broadcast_arrays(layout.offset - x, -second, z * sin - y * cos)),
        centre_line=line,
    )


def _turned(nominal: _Nominal, turn: Any, tilt: Any) -> _Turned:
    """Return the axes after a rotation of the gear about the pitch point by `turn` in the plane, with the
    sense of the shaft angle, and by `tilt` out of it.
    """
    angle = nominal.angle + turn
    sin, cos, sin_tilt, cos_tilt = np.sin(angle), np.cos(angle), np.sin(tilt), np.cos(tilt)
    versed = 2.0 * np.sin(0.5 * np.asarray(tilt)) ** 2
    out, down, aside = nominal.arm
    # k2 changes by 2 sin(turn/2) along the mean direction of k2 x x, and k2 x x by as much against the mean
    # direction of k2.
    step, middle = 2.0 * np.sin(0.5 * np.asarray(turn)), nominal.angle + 0.5 * np.asarray(turn)
    change = -out * sin_tilt - down * versed  # along k2 as turned in the plane
    moved = (
        down * sin_tilt - out * versed,
        (down * np.cos(middle) - aside * np.sin(middle)) * step + change * sin,
        (-down * np.sin(middle) - aside * np.cos(middle)) * step + change * cos,
    )
    normal = np.sqrt((cos_tilt * sin) ** 2 + sin_tilt**2)
    # Axes that remain parallel keep their line of centres.
    x = (
        np.where(normal == 0.0, 1.0, nominal.sign * cos_tilt * sin / normal),
        np.where(normal == 0.0, 0.0, -nominal.sign * sin_tilt / normal),
    )
    return _Turned(np.stack(np.broadcast_arrays(*moved)), x, (-x[1], x[0]), normal, cos_tilt * cos)


def _widened(nominal: _Nominal, turn: Any, tilt: Any) -> Complex:
    """Return d' - |D|, the increase of the shaft angle by a tilt, as the angle below 90 deg between
    (sin d', cos d') and (sin D, cos D).
    """
    angle = nominal.sign * (nominal.angle + turn)
    sin, cos, sin_tilt, cos_tilt = np.sin(angle), np.cos(angle), np.sin(tilt), np.cos(tilt)
    normal = np.sqrt((cos_tilt * sin) ** 2 + sin_tilt**2)
    rise = np.where(sin_tilt == 0.0, 0.0, sin_tilt * sin_tilt / (normal + cos_tilt * sin))
    return np.asarray(np.arctan(rise * cos / (normal * sin + cos_tilt * cos * cos)))


def _offset_error(nominal: _Nominal, turned: _Turned, moved: Complex) -> Complex:
    """Return E' - E, for a foot displaced by `moved`, without loss of digits by E."""
    first, second = turned.x
    versed = np.where(np.real(first) > 0.0, second * second / (1.0 + first), 1.0 - first)
    return np.asarray(moved[0] * first + moved[1] * second - nominal.offset * versed)


def _feet(nominal: _Nominal, turned: _Turned, moved: Complex) -> tuple[Complex, Complex]:
    """Return the distances along the pinion and gear axes from the old to the new feet of the common
    perpendicular. The old foot on the gear axis is the displaced one.
    """
    first, second = turned.y
    across = (nominal.offset + moved[0]) * first + moved[1] * second
    gear = np.where(turned.normal == 0.0, 0.0, -across / (nominal.sign * turned.normal))
    return moved[2] + gear * turned.along, gear


def _made(kind: Kind, values: dict[str, Any]) -> Kind:
    """Return errors with these values; values of single designs become plain numbers."""
    arrays = np.broadcast_arrays(*values.values())
    shown = (float(array) if array.ndim == 0 else array.copy() for array in arrays)
    return unchecked(kind, **dict(zip(values, shown, strict=True)))


def from_mesh(design: Design, errors: MeshErrors) -> Errors:
    """Return the errors about the common perpendicular that are equivalent to `errors` at the mesh.

    Parameters
    ----------
    design : Design
        Its errors are ignored.
    errors : MeshErrors
        In mm and rad; arrays broadcast with those of the design.

    Returns
    -------
    Errors
        NaN if the pair has no pitch point, or if `in_plane` rotates the axes past parallel. The errors may
        exceed the limits for errors in design files.
    """
    nominal = _nominal(design, design.sense * errors.in_plane)
    result = _about_perpendicular(nominal, errors)
    past = _past_parallel(design, errors)
    return _made(Errors(), {name: np.where(past, np.nan, value) for name, value in result.items()})


def _past_parallel(design: Design, errors: MeshErrors) -> Mask:
    """Return whether the rotation in the plane changes the sign of D; always False on parallel axes."""
    layout = layout_of(design, with_errors=False)
    turned = layout.shaft_angle + layout.sense * errors.in_plane
    return np.asarray(~layout.parallel & (layout.shaft_angle * turned < 0.0))


def _about_perpendicular(nominal: _Nominal, errors: MeshErrors) -> dict[str, Complex]:
    """Return the errors about the common perpendicular by their names."""
    with np.errstate(invalid="ignore", divide="ignore"):
        turned = _turned(nominal, nominal.sense * errors.in_plane, errors.out_of_plane)
        moved = _add(turned.moved, nominal.centre_line, errors.centre_distance)
        pinion, gear = _feet(nominal, turned, moved)
        more = _widened(nominal, nominal.sense * errors.in_plane, errors.out_of_plane)
        return {
            "offset": _offset_error(nominal, turned, moved),
            "shaft_angle": errors.in_plane + nominal.sense * nominal.sign * more,
            "pinion_axial": errors.pinion_axial - pinion,
            "gear_axial": errors.gear_axial - gear,
        }


def by_mesh_errors(design: Design, rates: FloatArray) -> FloatArray:
    """Return derivatives by the errors at the mesh.

    They follow by the chain rule, with derivatives of `from_mesh` by a complex step, exact to rounding.

    Parameters
    ----------
    design : Design
        With the errors at which the derivatives are taken.
    rates : ndarray, shape (batch, ..., 4)
        Derivatives by the errors about the common perpendicular, in the order of `Errors`.

    Returns
    -------
    ndarray, shape (batch, ..., 5)
        In the order of `MeshErrors`. NaN where `at_mesh` is NaN, and for a tilt of axes that are parallel
        under these errors.
    """
    errors = at_mesh(design)
    nominal = _nominal(design, design.sense * errors.in_plane)
    last = _Nominal(**{name: np.asarray(value)[..., None] for name, value in vars(nominal).items()})
    steps = COMPLEX_STEP * 1j * np.eye(len(fields(MeshErrors)))
    moved = {
        name: np.asarray(value)[..., None] + steps[k] for k, (name, value) in enumerate(vars(errors).items())
    }
    result = _about_perpendicular(last, unchecked(errors, **moved))
    by = np.stack(np.broadcast_arrays(*result.values()), axis=-2).imag / COMPLEX_STEP
    still = (nominal.angle + nominal.sense * errors.in_plane == 0.0) & (
        np.asarray(errors.out_of_plane) == 0.0
    )
    tilted = np.array([field.name == "out_of_plane" for field in fields(MeshErrors)])
    by = np.where(still[..., None, None] & tilted, np.nan, by)
    batch, more = design.batch_shape, rates.ndim - 1 - len(design.batch_shape)
    by = np.broadcast_to(by, (*batch, *by.shape[-2:])).reshape(*batch, *[1] * more, *by.shape[-2:])
    turned = np.asarray((rates[..., None, :] @ by)[..., 0, :])
    missing = np.isnan(rates)
    partly_missing = np.asarray(missing.any(axis=-1) & ~missing.all(axis=-1))
    if partly_missing.any():  # a missing derivative is not needed where its factor is 0
        terms = np.where(missing[..., None] & (by == 0.0), 0.0, rates[..., None] * by)
        turned = np.where(partly_missing[..., None], terms.sum(axis=-2), turned)
    return turned


def at_mesh(design: Design, centre_distance: Quantity = 0.0, out_of_plane: Quantity = 0.0) -> MeshErrors:
    """Return the errors at the mesh that are equivalent to the errors of a design about the common
    perpendicular.

    Parameters
    ----------
    design : Design
        With its errors.
    centre_distance, out_of_plane : float or array
        The fixed one of these two, mm or rad (see the module docstring); the other is computed.

    Returns
    -------
    MeshErrors
        NaN if there are none: without a pitch point, or for an offset that no tilt gives.
    """
    nominal, errors = _nominal(design, design.sense * design.errors.shaft_angle), design.errors
    line = nominal.centre_line
    with np.errstate(invalid="ignore", divide="ignore"):
        tilted = np.abs(line[0]) > 0.5
        tilt = np.where(tilted, out_of_plane, _tilt(nominal, errors, centre_distance))
        turned = _turned(nominal, _turn(nominal, errors, tilt), tilt)
        remaining = errors.offset - _offset_error(nominal, turned, turned.moved)
        across = line[0] * turned.x[0] + line[1] * turned.x[1]
        distance = np.where(tilted, remaining / across, centre_distance)
        pinion, gear = _feet(nominal, turned, _add(turned.moved, line, distance))
        result = {
            "centre_distance": distance,
            "in_plane": nominal.sense * _turn(nominal, errors, tilt),
            "out_of_plane": tilt,
            "pinion_axial": errors.pinion_axial + pinion,
            "gear_axial": errors.gear_axial + gear,
        }
    return _made(MeshErrors(), result)


def pivot_distance(design: Design) -> FloatArray:
    """Return the distance of the pitch point from the common perpendicular.

    Parameters
    ----------
    design : Design
        A single design or a batch.

    Returns
    -------
    ndarray
        mm, batch shape.
    """
    point = mounting_of(design).pitch_point
    return np.asarray(np.hypot(point[..., 1], point[..., 2]))


def _add(moved: Complex, line: FloatArray, distance: Any) -> Complex:
    """Return a displacement plus a distance along a direction, both by components on the leading axis."""
    return np.stack([start + part * distance for start, part in zip(moved, line, strict=True)])


def _turn(nominal: _Nominal, errors: Errors, tilt: Any) -> FloatArray:
    """Return the signed rotation in the plane that with a tilt gives d': cos d' = cos o cos D."""
    error = nominal.sense * errors.shaft_angle
    total = nominal.sign * (nominal.angle + error)
    rise = -(np.sin(tilt) ** 2) / (np.sqrt(np.sin(total - tilt) * np.sin(total + tilt)) + np.sin(total))
    rise = np.where(np.asarray(tilt) == 0.0, 0.0, rise)
    # |D| - d', the difference of the angles with the tangents (sin d' + rise)/cos d' and sin d'/cos d'.
    less = np.arctan2(rise * np.cos(total), 1.0 + rise * np.sin(total))
    return np.asarray(error + nominal.sign * less)


def _tilt(nominal: _Nominal, errors: Errors, distance: Any) -> FloatArray:
    """Return the tilt that gives the offset error if the centre distance is fixed."""
    # Maximum secant steps to a tilt; 3 to 6 are needed.
    secant_max_steps = 30
    # Step in rad below which the secant slope is not updated.
    least_secant_step_rad = 1e-8

    def left(tilt: Any) -> FloatArray:
        """Return the remaining offset error, mm."""
        turned = _turned(nominal, _turn(nominal, errors, tilt), tilt)
        return _offset_error(nominal, turned, _add(turned.moved, nominal.centre_line, distance)) - (
            errors.offset
        )

    before = left(0.0)
    slope = np.broadcast_to(nominal.arm[1], before.shape)
    old, tilt = np.zeros_like(before), -before / slope
    for _ in range(secant_max_steps):
        now = left(tilt)
        # The slope of shorter steps would be dominated by rounding.
        slope = np.where(np.abs(tilt - old) > least_secant_step_rad, (now - before) / (tilt - old), slope)
        old, before, tilt = tilt, now, tilt - now / slope
        if not np.any(np.abs(tilt - old) > 1e-17 + 1e-15 * np.abs(tilt)):
            break
    lost = np.abs(left(tilt)) > 1e-9 * (1.0 + np.abs(errors.offset))
    return np.where(lost, np.nan, tilt)
