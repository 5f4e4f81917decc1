"""Assembly errors as they are measured at the mesh, and about the common perpendicular.

`Errors` turn and move the axes at their common perpendicular, which can lie metres from the teeth;
`MeshErrors` do so at the pitch point P of the layout without errors. The pinion stays, the gear is moved
as a rigid body, in S_f:

1. by `in_plane` about x through P: in the plane parallel to both axes, in which the shaft angle lies;
2. by `out_of_plane` about P, around the direction square to x and to its axis as turned by 1, so that
   k2 gains sin(out_of_plane) along +x;
3. by `centre_distance` along u, from the point of the pinion's axis that is nearest to P to that of the
   gear's, which on parallel axes is their distance;
4. each member along its own axis by its axial error.

With the shaft angle d and its sense s, D = s (d + in_plane) and o = out_of_plane the gear's axis runs along
k2' = (sin o, cos o sin D, cos o cos D) through q = (E, 0, 0) + g, with g what the foot (E, 0, 0) was
moved by. The new common perpendicular lies along x' = s (k2' x k1)/n, n = |k2' x k1|; with y' = k1 x x' the
errors about it are

    E' = q.x',   tan d' = n/(k2'.k1),   t = -q.y'/(s n),   z = q.k1 + t k2'.k1,

t and z the ways from q and from the old foot on the pinion's axis to the new feet, which axial positions are
counted from. g is formed from differences, so that a far pivot costs no digits.

These are five errors for the four freedoms of two axes with a place on each. The way back therefore holds
one: the tilt out of the plane where u lies within 60 deg of x, as on ordinary crossed axes, where the centre
distance then makes the offset; elsewhere the centre distance, which on intersecting axes is the same as two
axial errors.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from os import PathLike
from typing import Any, TypeAlias, TypeVar

import numpy as np

from ..arrays import COMPLEX_STEP, FloatArray, Mask, Quantity
from ..design import file
from ..design.model import Design, Errors, MeshErrors, unchecked
from .frames import layout_of
from .mounting import mounting_of

MOST_STEPS = 30
"""Secant steps to a tilt; 3 to 6 are needed."""
LEAST_STEP = 1e-8
"""Rad, of which the secant's slope is taken."""

Kind = TypeVar("Kind", Errors, MeshErrors)
Complex: TypeAlias = np.ndarray[Any, np.dtype[Any]]
"""Values that may be complex, by whose imaginary parts they are differentiated."""


@dataclass(frozen=True, eq=False)
class _Nominal:
    """Layout without errors: offset E, its signed shaft angle and the sign of that, the foot (E, 0, 0) seen
    from the pitch point along x, k2 and x x k2 (`arm`), and u (`centre_line`), both by components."""

    offset: FloatArray
    sense: FloatArray
    angle: FloatArray
    sign: FloatArray
    arm: FloatArray
    centre_line: FloatArray


@dataclass(frozen=True, eq=False)
class _Turned:
    """Axes after both turns: `moved` is g, `x` and `y` the x and y components of x' and y'; `normal` is n,
    `along` k2'.k1."""

    moved: FloatArray
    x: tuple[FloatArray, FloatArray]
    y: tuple[FloatArray, FloatArray]
    normal: FloatArray
    along: FloatArray


def _nominal(design: Design, lean: Any = 0.0) -> _Nominal:
    """Give the layout of a design; parallel axes have the sign of the turn `lean` that they are given."""
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
    """Turn the gear about the pitch point by `turn` in the plane, with the sense of the shaft angle, then by
    `tilt` out of it."""
    angle = nominal.angle + turn
    sin, cos, sin_tilt, cos_tilt = np.sin(angle), np.cos(angle), np.sin(tilt), np.cos(tilt)
    versed = 2.0 * np.sin(0.5 * np.asarray(tilt)) ** 2
    out, down, aside = nominal.arm
    # k2 and x x k2 turn by 2 sin(turn/2) towards their means.
    step, middle = 2.0 * np.sin(0.5 * np.asarray(turn)), nominal.angle + 0.5 * np.asarray(turn)
    change = -out * sin_tilt - down * versed  # along k2 as turned in the plane
    moved = (
        down * sin_tilt - out * versed,
        (down * np.cos(middle) - aside * np.sin(middle)) * step + change * sin,
        (-down * np.sin(middle) - aside * np.cos(middle)) * step + change * cos,
    )
    normal = np.sqrt((cos_tilt * sin) ** 2 + sin_tilt**2)
    # Axes that stay parallel keep their line of centres.
    x = (
        np.where(normal == 0.0, 1.0, nominal.sign * cos_tilt * sin / normal),
        np.where(normal == 0.0, 0.0, -nominal.sign * sin_tilt / normal),
    )
    return _Turned(np.stack(np.broadcast_arrays(*moved)), x, (-x[1], x[0]), normal, cos_tilt * cos)


def _widened(nominal: _Nominal, turn: Any, tilt: Any) -> Complex:
    """Find d' - |D|, by which a tilt widens the shaft angle, as the angle, below 90 deg, between
    (sin d', cos d') and (sin D, cos D)."""
    angle = nominal.sign * (nominal.angle + turn)
    sin, cos, sin_tilt, cos_tilt = np.sin(angle), np.cos(angle), np.sin(tilt), np.cos(tilt)
    normal = np.sqrt((cos_tilt * sin) ** 2 + sin_tilt**2)
    rise = np.where(sin_tilt == 0.0, 0.0, sin_tilt * sin_tilt / (normal + cos_tilt * sin))
    return np.asarray(np.arctan(rise * cos / (normal * sin + cos_tilt * cos * cos)))


def _offset_error(nominal: _Nominal, turned: _Turned, moved: Complex) -> Complex:
    """Find E' - E, where the foot was moved by `moved`, without the digits of E."""
    first, second = turned.x
    versed = np.where(np.real(first) > 0.0, second * second / (1.0 + first), 1.0 - first)
    return np.asarray(moved[0] * first + moved[1] * second - nominal.offset * versed)


def _feet(nominal: _Nominal, turned: _Turned, moved: Complex) -> tuple[Complex, Complex]:
    """Find the ways along pinion and gear axis from the old feet of the common perpendicular, the gear's
    as it was moved, to the new ones."""
    first, second = turned.y
    across = (nominal.offset + moved[0]) * first + moved[1] * second
    gear = np.where(turned.normal == 0.0, 0.0, -across / (nominal.sign * turned.normal))
    return moved[2] + gear * turned.along, gear


def _made(kind: Kind, values: dict[str, Any]) -> Kind:
    """Give errors of these values, plain numbers where they are single ones."""
    arrays = np.broadcast_arrays(*values.values())
    shown = (float(array) if array.ndim == 0 else array.copy() for array in arrays)
    return unchecked(kind, **dict(zip(values, shown, strict=True)))


def from_mesh(design: Design, errors: MeshErrors) -> Errors:
    """Give the errors about the common perpendicular that are the same as `errors` at the mesh of a design.

    Parameters
    ----------
    design : Design
        Its own errors do not matter.
    errors : MeshErrors
        In mm and rad; arrays broadcast with the design's.

    Returns
    -------
    Errors
        NaN where the pair has no pitch point, or its axes are turned past parallel. They may pass the
        limits of those that users give.
    """
    nominal = _nominal(design, design.sense * errors.in_plane)
    return _made(Errors(), _about_perpendicular(nominal, errors))


def _about_perpendicular(nominal: _Nominal, errors: MeshErrors) -> dict[str, Complex]:
    """Find the errors about the common perpendicular by their names."""
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
    """Give derivatives (*batch, ..., 5) by the errors at the mesh for those (*batch, ..., 4) by the errors
    about the common perpendicular, under the errors that a design has, in the orders of their classes.

    By the chain rule, with derivatives of `from_mesh` from a complex step, exact to rounding; NaN where
    `at_mesh` gives none, and by a tilt of axes that are parallel under these errors."""
    own = at_mesh(design)
    nominal = _nominal(design, design.sense * own.in_plane)
    last = _Nominal(**{name: np.asarray(value)[..., None] for name, value in vars(nominal).items()})
    steps = COMPLEX_STEP * 1j * np.eye(len(fields(MeshErrors)))
    moved = {
        name: np.asarray(value)[..., None] + steps[k] for k, (name, value) in enumerate(vars(own).items())
    }
    found = _about_perpendicular(last, unchecked(own, **moved))
    by = np.stack(np.broadcast_arrays(*found.values()), axis=-2).imag / COMPLEX_STEP
    still = (nominal.angle + nominal.sense * own.in_plane == 0.0) & (np.asarray(own.out_of_plane) == 0.0)
    tilted = np.array([field.name == "out_of_plane" for field in fields(MeshErrors)])
    by = np.where(still[..., None, None] & tilted, np.nan, by)
    batch, more = design.batch_shape, rates.ndim - 1 - len(design.batch_shape)
    by = np.broadcast_to(by, (*batch, *by.shape[-2:])).reshape(*batch, *[1] * more, *by.shape[-2:])
    return np.asarray((rates[..., None, :] @ by)[..., 0, :])


def holds_tilt(design: Design) -> Mask:
    """Say (batch shape) whether the way to errors at the mesh holds the tilt out of the plane, and not the
    centre distance."""
    return np.asarray(np.abs(_nominal(design).centre_line[0]) > 0.5)


def at_mesh(design: Design, centre_distance: Quantity = 0.0, out_of_plane: Quantity = 0.0) -> MeshErrors:
    """Give the errors at the mesh that are the same as those of a design about the common perpendicular.

    Parameters
    ----------
    design : Design
        With its errors.
    centre_distance, out_of_plane : float or array
        Of these two, mm and rad, the one that is held (`holds_tilt`); the other is found.

    Returns
    -------
    MeshErrors
        NaN where there are none: no pitch point, or an offset that no tilt gives.
    """
    nominal, errors = _nominal(design, design.sense * design.errors.shaft_angle), design.errors
    line = nominal.centre_line
    with np.errstate(invalid="ignore", divide="ignore"):
        tilted = np.abs(line[0]) > 0.5
        tilt = np.where(tilted, out_of_plane, _tilt(nominal, errors, centre_distance))
        turned = _turned(nominal, _turn(nominal, errors, tilt), tilt)
        rest = errors.offset - _offset_error(nominal, turned, turned.moved)
        across = line[0] * turned.x[0] + line[1] * turned.x[1]
        distance = np.where(tilted, rest / across, centre_distance)
        pinion, gear = _feet(nominal, turned, _add(turned.moved, line, distance))
        found = {
            "centre_distance": distance,
            "in_plane": nominal.sense * _turn(nominal, errors, tilt),
            "out_of_plane": tilt,
            "pinion_axial": errors.pinion_axial + pinion,
            "gear_axial": errors.gear_axial + gear,
        }
    return _made(MeshErrors(), found)


def pivot_distance(design: Design) -> FloatArray:
    """Find how far the pitch point lies from the common perpendicular, mm (batch shape)."""
    point = mounting_of(design).pitch_point
    return np.asarray(np.hypot(point[..., 1], point[..., 2]))


def _add(moved: Complex, line: FloatArray, distance: Any) -> Complex:
    """Add a way along a direction, both of components on the leading axis."""
    return np.stack([own + part * distance for own, part in zip(moved, line, strict=True)])


def _turn(nominal: _Nominal, errors: Errors, tilt: Any) -> FloatArray:
    """Find the turn in the plane, signed, that with a tilt gives the shaft angle: cos d' = cos o cos D."""
    error = nominal.sense * errors.shaft_angle
    whole = nominal.sign * (nominal.angle + error)
    rise = -(np.sin(tilt) ** 2) / (np.sqrt(np.sin(whole - tilt) * np.sin(whole + tilt)) + np.sin(whole))
    rise = np.where(np.asarray(tilt) == 0.0, 0.0, rise)
    # What the tilt takes from the angle, as a difference of two angles of the tangents
    # (sin D' + rise, cos D') and (sin D', cos D').
    less = np.arctan2(rise * np.cos(whole), 1.0 + rise * np.sin(whole))
    return np.asarray(error + nominal.sign * less)


def _tilt(nominal: _Nominal, errors: Errors, distance: Any) -> FloatArray:
    """Find the tilt that gives the offset error where the centre distance is held."""

    def left(tilt: Any) -> FloatArray:
        """Give what is left of the offset error, mm."""
        turned = _turned(nominal, _turn(nominal, errors, tilt), tilt)
        return _offset_error(nominal, turned, _add(turned.moved, nominal.centre_line, distance)) - (
            errors.offset
        )

    before = left(0.0)
    slope = np.broadcast_to(nominal.arm[1], before.shape)
    old, tilt = np.zeros_like(before), -before / slope
    for _ in range(MOST_STEPS):
        now = left(tilt)
        # Of shorter steps the slope would be that of rounding.
        slope = np.where(np.abs(tilt - old) > LEAST_STEP, (now - before) / (tilt - old), slope)
        old, before, tilt = tilt, now, tilt - now / slope
        if not np.any(np.abs(tilt - old) > 1e-17 + 1e-15 * np.abs(tilt)):
            break
    lost = np.abs(left(tilt)) > 1e-9 * (1.0 + np.abs(errors.offset))
    return np.where(lost, np.nan, tilt)


def read_design(path: str | PathLike[str]) -> Design:
    """Read a design file (TOML, mm and degrees), its errors about the common perpendicular or at the mesh.

    Parameters
    ----------
    path : path-like
        The file, or 'ni-2017' for the built-in design.

    Returns
    -------
    Design
        In mm and rad, with its errors about the common perpendicular.

    Raises
    ------
    DesignError
        With every fault found, or with the reason why there is no text.
    """
    return file.read_design(path, from_mesh)
