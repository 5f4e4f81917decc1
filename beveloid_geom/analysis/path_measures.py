"""Measures of a path of contact that the paper's statements use: lengths, angles, locations, shifts.

The paper does not define its words. Each word is therefore measured in several ways, on pinion and gear:

- Side view: the flank as in the figures of the paper, z along the axis (toe to heel) against the radius r.
- On the tooth: the path as a curve in space on the flank of the member.
- Angle: between path and axial direction in the side view, of the chord between both ends and of the
  tangent in the middle, in degrees from -90 to 90.
- Location: z from mid-face of the position at mid-roll, and of the middle between the ends of the path.
- Shift under an error: the middle of the path without the error is compared with the path under the error,
  extended beyond the flank. Along the face: the difference in z at the same flank parameter l, or at the
  same radius r. Perpendicular ("square"): in the side view, the difference at the same r times the sine of
  the angle of the tangent; on the tooth, the difference at the same l times the ratio of the perpendicular
  to the lengthwise shift (`sensitivity`). At mid-roll: the difference in z between the middles of the paths
  on the flanks. Shifts are positive towards +z.

Lengths are in mm, angles in deg."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Codes, FloatArray
from ..contact.path import ContactPath, path_of_contact
from ..design.member import Member
from ..design.model import Design
from ..gear.flank import flank_patch, flank_point, half_thickness_angle, normal_rates, trace_parameter
from ..gear.flank_limits import active_range
from ..gear.rack import reference_radius
from .sensitivity import path_sensitivity

PATH_POINTS, EXTENDED_POINTS = 201, 2001
"""Number of positions of a path, and of an extended path."""
SHIFTS = (
    "along the face, equal l",
    "along the face, equal r",
    "square, side view",
    "square, on the tooth",
    "at mid-roll",
)


@dataclass(frozen=True, eq=False)
class PathMeasures:
    """Measures of n paths; NaN, or -1, without a path.

    Attributes
    ----------
    contact_ratio : FloatArray
        (n,), Eq. 16.
    length, angle, location : dict
        (2 members, n) by the name of the measure: 'side view' and 'on the tooth', mm; 'chord' and 'middle',
        deg; 'middle' and 'between ends', mm.
    limit : Codes
        (n, 2), codes of `Limit` at the ends.
    """

    contact_ratio: FloatArray
    length: dict[str, FloatArray]
    angle: dict[str, FloatArray]
    location: dict[str, FloatArray]
    limit: Codes


@dataclass(frozen=True, eq=False)
class Sweep:
    """Paths under parabola coefficients: `size` (n,) from 0, 1/mm, times the `signs` of the members."""

    signs: tuple[int, int]
    size: FloatArray
    paths: PathMeasures


def measures_of(design: Design, flank: str) -> PathMeasures:
    """Return measures of the paths of a design with one batch axis."""
    path = path_of_contact(design, flank, PATH_POINTS)
    z, r = _side_view(path)
    length, angle = in_side_view(path)
    steps = np.diff(_tooth_points(path), axis=-2)
    near = slice(PATH_POINTS // 2 - 1, PATH_POINTS // 2 + 2, 2)
    return PathMeasures(
        contact_ratio=np.where(path.ends.limit[:, 0] < 0, np.nan, path.ends.contact_ratio),
        length={
            "side view": length,
            "on the tooth": np.linalg.norm(steps, axis=-1).sum(axis=-1),
        },
        angle={
            "chord": angle,
            "middle": _angle(z[..., near], r[..., near]),
        },
        location={"middle": z[..., PATH_POINTS // 2], "between ends": 0.5 * (z[..., 0] + z[..., -1])},
        limit=path.ends.limit,
    )


def in_side_view(path: ContactPath) -> tuple[FloatArray, FloatArray]:
    """Return length and angle of a path in the side view: the default meaning of both words.

    Parameters
    ----------
    path : ContactPath
        One path or a batch.

    Returns
    -------
    length : ndarray, shape (2, ...)
        Length on pinion and gear, mm.
    angle : ndarray, shape (2, ...)
        Angle of the chord on pinion and gear, deg.
    """
    z, r = _side_view(path)
    return np.hypot(np.diff(z), np.diff(r)).sum(axis=-1), _angle(z[..., [0, -1]], r[..., [0, -1]])


def _side_view(path: ContactPath) -> tuple[FloatArray, FloatArray]:
    return np.stack((path.pinion_z, path.gear_z)), np.stack((path.pinion_r, path.gear_r))


def _angle(z: FloatArray, r: FloatArray) -> FloatArray:
    """Return the angle (deg) to the axial direction of the step between two points on the last axis."""
    along, up = np.diff(z)[..., 0], np.diff(r)[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.degrees(np.arctan(up / along)))


def _tooth_points(path: ContactPath) -> FloatArray:
    """Return points (2, n, positions, 3) of paths on the flanks of both members, in their frames."""
    l, u = np.stack((path.l1, path.l2)), np.stack((path.u1, path.u2))
    shape = (2, -1, l.shape[-1])
    return flank_point(path.design.stacked_members(), path.flank, l.reshape(shape), u.reshape(shape))


def sweep(design: Design, flank: str, signs: tuple[int, int], largest: float) -> Sweep:
    """Return the paths of a design under coefficients from 0 to a largest one.

    Parameters
    ----------
    design : Design
        A single design. Its parabolas are replaced.
    flank : {'right', 'left'}
    signs : tuple of int
        Signs of the coefficients of pinion and gear.
    largest : float
        Largest magnitude of the coefficients, 1/mm.

    Returns
    -------
    Sweep
    """
    # Number of coefficients of a sweep.
    size = np.linspace(0.0, largest, 21)
    return Sweep(signs, size, measures_of(design.with_parabola(signs[0] * size, signs[1] * size), flank))


def unwrapped(angle: FloatArray) -> FloatArray:
    """Return angles (..., n) of lines, deg, as a continuous sequence: a rotation by 180 deg gives the same
    line."""
    return np.asarray(np.unwrap(angle, period=180.0, axis=-1))


def shifts(design: Design, flank: str, error: str, size: float) -> dict[str, FloatArray]:
    """Return the shifts of the path of a single design under -size and +size of an error.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
    error : str
        Name of the error, as in `pair.misalignment`.
    size : float
        Size of the error, mm or rad.

    Returns
    -------
    dict
        Shifts by the names of SHIFTS, each of shape (2 members, 2), mm; NaN without a path.
    """
    results = {name: np.full((2, 2), np.nan) for name in SHIFTS}
    middle = path_of_contact(design, flank, PATH_POINTS)
    if middle.l1.size == 0:
        return results
    moved = design.with_errors(replace(design.errors, **{error: np.array((-size, size))}))
    window = _window(design, flank)
    on_flanks, curve = path_of_contact(moved, flank, 3), path_of_contact(moved, flank, l1=window)
    start = min(int(np.searchsorted(window, middle.l1[PATH_POINTS // 2])), EXTENDED_POINTS - 2)
    near, rates = slice(PATH_POINTS // 2 - 1, PATH_POINTS // 2 + 2, 2), path_sensitivity(design, flank)
    for j, (l, z, r) in enumerate((("l1", "pinion_z", "pinion_r"), ("l2", "gear_z", "gear_r"))):
        held_l, held_z, held_r = (getattr(middle, name)[PATH_POINTS // 2] for name in (l, z, r))
        angle = np.radians(_angle(getattr(middle, z)[near], getattr(middle, r)[near]))
        ratio = rates.square_shift_by[1, j, 0] / rates.face_shift_by[1, j, 0]
        for k in (0, 1):
            at_l, at_r = (
                _at(getattr(curve, name)[k], getattr(curve, z)[k], held, start) - held_z
                for name, held in ((l, held_l), (r, held_r))
            )
            at_roll = getattr(on_flanks, z)[k, 1] - held_z
            values = (at_l, at_r, at_r * abs(np.sin(angle)), at_l * ratio, at_roll)
            for name, value in zip(SHIFTS, values, strict=True):
                results[name][j, k] = value
    return results


def _window(design: Design, flank: str) -> FloatArray:
    """Return pinion flank parameters (EXTENDED_POINTS,) from below the root to above the tip, mm."""
    low, high = map(float, active_range(design.pinion, flank))
    return np.linspace(low - 0.1 * (high - low), high + 0.1 * (high - low), EXTENDED_POINTS)


def _at(row: FloatArray, z: FloatArray, wanted: float, start: int) -> float:
    """Return z of a curve where a row of values equals `wanted`, on the monotone part around position
    `start`; NaN if the value does not occur there."""
    steps = np.diff(row)
    if not np.isfinite(row[start]) or not np.isfinite(steps[start]):
        return np.nan
    away = np.flatnonzero(~(steps * steps[start] > 0.0))
    low = away[away < start].max(initial=-1) + 1
    high = away[away > start].min(initial=steps.size) + 1
    order = np.argsort(row[low:high]) + low
    return float(np.interp(wanted, row[order], z[order], left=np.nan, right=np.nan))


def concavity(design: Design, flank: str, size: float) -> dict[str, FloatArray]:
    """Return measures of the concavity of the flanks at mid-face relative to the involute, by name: arrays
    (2 members, 2), with the parabola coefficients +size and -size (1/mm) on the last axis.


    The measures are the metal left near root and tip, mm along the circle (the smaller value for +size, the
    larger for -size), and the decrease of the profile curvature at l = 0, 1/mm."""
    metal, curvature = np.empty((2, 2)), np.empty((2, 2))
    for j, member in enumerate(design.members):
        plain = replace(member, tool=member.tool.with_parabola(0.0))
        for k, (sign, pick) in enumerate(((1.0, np.min), (-1.0, np.max))):
            bent = replace(member, tool=member.tool.with_parabola(sign * size))
            _, added = added_metal(member, flank, sign * size)
            metal[j, k] = pick(added[near_ends(added.size)])
            curvature[j, k] = _profile_curvature(plain, flank) - _profile_curvature(bent, flank)
    return {"metal near root and tip": metal, "curvature of the profile": curvature}


def added_metal(member: Member, flank: str, parabola: float) -> tuple[FloatArray, FloatArray]:
    """Return radii (n,), mm, that the involute profile at mid-face and the profile with a parabola
    coefficient (1/mm) have in common, from root to tip, and the metal (n,) that the coefficient leaves there,
    mm along the circle."""
    plain, bent = (replace(member, tool=member.tool.with_parabola(a)) for a in (0.0, parabola))
    (r, thick), (other_r, other_thick) = _profile(plain, flank), _profile(bent, flank)
    start = int(other_r.argmin())  # the radius of an undercut profile turns back there
    other_r, other_thick = other_r[start:], other_thick[start:]
    both = ~((r < other_r[0]) | (r > other_r[-1]))
    return r[both], np.interp(r[both], other_r, other_thick) - thick[both]


def near_ends(count: int) -> list[int]:
    """Return the indices of the points near root and tip of a profile with `count` points."""
    return [count // 20, count - 1 - count // 20]


def _profile(member: Member, flank: str) -> tuple[FloatArray, FloatArray]:
    """Return radii (n,) and half tooth thicknesses (n,) of a flank at mid-face from root to tip, mm."""
    # The highest parameter belongs to the large end; at mid-face the tooth ends lower.
    low, high = map(float, active_range(member, flank))
    l = np.linspace(low, high, EXTENDED_POINTS)
    point = flank_point(member, flank, l, z=0.0)
    r = np.hypot(point[:, 0], point[:, 1])
    height = float(member.profile_shift + member.tip_height) * float(member.tool.normal_module)
    inside = r <= float(reference_radius(member)) + height
    return r[inside], (r * half_thickness_angle(member, flank, l, 0.0))[inside]


def _profile_curvature(member: Member, flank: str) -> float:
    """Return the normal curvature (1/mm) of a flank across its trace at l = 0, mid-face; convex > 0."""
    u = trace_parameter(member, flank, 0.0, 0.0)
    step = flank_patch(member, flank, 0.0, u).tangent_l
    turn, _ = normal_rates(member, flank, 0.0, u)
    return float((turn * step).sum() / (step * step).sum())
