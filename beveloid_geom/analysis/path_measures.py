"""What the paper's statements on paths are measured by: lengths, angles, locations, shifts.

The paper defines none of its words, so each is taken in the ways it can be meant, on pinion and gear:

- Side view: the flank as in the paper's figures, z along the axis (toe to heel) against the radius r.
- On the tooth: the path as a curve in space on the member's own flank.
- Angle: between path and axial direction in the side view, of the chord between both ends and of the
  tangent in the middle, in degrees from -90 to 90.
- Location: z from mid-face of the position in the middle of the path's roll, and of the middle
  between its ends.
- Shift under an error: the middle of the path without the error is held against the path under it,
  extended beyond the flank. Along the face: the difference in z at the same flank parameter l, or at
  the same radius r. Square to the path: in the side view, that at the same r times the sine of the
  angle of the tangent; on the tooth, that at the same l times the ratio in which the flank turns a
  small shift along it into one square to the path (`sensitivity`). At mid-roll: the difference in z
  between the middles of the paths on the flanks. Positive towards the heel.

Lengths mm, angles deg.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Codes, FloatArray
from ..contact.ellipse import normal_rates
from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design, Member
from ..gear.flank import (
    flank_patch,
    flank_point,
    half_thickness_angle,
    highest_parameter,
    root_parameter,
    trace_parameter,
)
from .sensitivity import path_sensitivity

STEPS, POINTS, DENSE = 21, 201, 2001
"""Coefficients of a sweep, positions of a path, positions of an extended one."""
SHIFTS = (
    "along the face, equal l",
    "along the face, equal r",
    "square, side view",
    "square, on the tooth",
    "at mid-roll",
)
BEYOND = 0.1
"""Share of the flank's depth by which a path is extended past root and tip."""


@dataclass(frozen=True, eq=False)
class Paths:
    """Measures of n paths: `contact_ratio` (n,), and by way of measuring, on pinion and gear (2, n):
    `length` ('side view', 'on the tooth'), `angle` ('chord', 'middle'), `location` ('middle',
    'between ends'). `limit` (n, 2): codes of `Limit` that end them. NaN, -1 without a path."""

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
    paths: Paths


def paths_of(design: Design, flank: str) -> Paths:
    """Find measures of the paths of a design with one batch axis."""
    path = path_of_contact(design, flank, POINTS)
    z, r = _side_view(path)
    length, angle = in_side_view(path)
    steps = np.diff(_tooth_points(path), axis=-2)
    near = slice(POINTS // 2 - 1, POINTS // 2 + 2, 2)
    return Paths(
        contact_ratio=np.where(path.ends.limit[:, 0] < 0, np.nan, path.ends.contact_ratio),
        length={
            "side view": length,
            "on the tooth": np.linalg.norm(steps, axis=-1).sum(axis=-1),
        },
        angle={
            "chord": angle,
            "middle": _angle(z[..., near], r[..., near]),
        },
        location={"middle": z[..., POINTS // 2], "between ends": 0.5 * (z[..., 0] + z[..., -1])},
        limit=path.ends.limit,
    )


def in_side_view(path: ContactPath) -> tuple[FloatArray, FloatArray]:
    """Find length (mm) and angle of the chord (deg) of a path in the side view, on pinion and gear (2, ...):
    what "length" and "angle" of a path mean where nothing else is said."""
    z, r = _side_view(path)
    return np.hypot(np.diff(z), np.diff(r)).sum(axis=-1), _angle(z[..., [0, -1]], r[..., [0, -1]])


def _side_view(path: ContactPath) -> tuple[FloatArray, FloatArray]:
    return np.stack((path.pinion_z, path.gear_z)), np.stack((path.pinion_r, path.gear_r))


def _angle(z: FloatArray, r: FloatArray) -> FloatArray:
    """Find the angle (deg) to the axial direction of the step between two points on the last axis."""
    along, up = np.diff(z)[..., 0], np.diff(r)[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.degrees(np.arctan(up / along)))


def _tooth_points(path: ContactPath) -> FloatArray:
    """Find points (2, n, positions, 3) of paths on the flanks of both members, each in its own frame."""
    l, u = np.stack((path.l1, path.l2)), np.stack((path.u1, path.u2))
    shape = (2, -1, l.shape[-1])
    return flank_point(path.design.stacked_members(), path.flank, l.reshape(shape), u.reshape(shape))


def sweep(design: Design, flank: str, signs: tuple[int, int], largest: float) -> Sweep:
    """Find paths of a design under coefficients from 0 to `largest` times the signs, 1/mm."""
    size = np.linspace(0.0, largest, STEPS)
    return Sweep(signs, size, paths_of(design.with_parabola(signs[0] * size, signs[1] * size), flank))


def unwrapped(angle: FloatArray) -> FloatArray:
    """Find angles (..., n) of lines, deg, followed continuously: a line turned by 180 deg is the same."""
    return np.asarray(np.unwrap(angle, period=180.0, axis=-1))


def shifts(design: Design, flank: str, error: str, size: float) -> dict[str, FloatArray]:
    """Find shifts (2 members, 2) of the path of a single design under -size and +size of an error, by the
    names of SHIFTS; NaN where a path is missing."""
    found = {name: np.full((2, 2), np.nan) for name in SHIFTS}
    middle = path_of_contact(design, flank, POINTS)
    if middle.l1.size == 0:
        return found
    moved = design.with_errors(replace(design.errors, **{error: np.array((-size, size))}))
    window = _window(design)
    on_flanks, curve = path_of_contact(moved, flank, 3), path_of_contact(moved, flank, l1=window)
    start = min(int(np.searchsorted(window, middle.l1[POINTS // 2])), DENSE - 2)
    near, rates = slice(POINTS // 2 - 1, POINTS // 2 + 2, 2), path_sensitivity(design, flank)
    for j, (l, z, r) in enumerate((("l1", "pinion_z", "pinion_r"), ("l2", "gear_z", "gear_r"))):
        held_l, held_z, held_r = (getattr(middle, name)[POINTS // 2] for name in (l, z, r))
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
                found[name][j, k] = value
    return found


def _window(design: Design) -> FloatArray:
    """Give pinion flank parameters (DENSE,) from below root to above tip, mm."""
    low, high = float(root_parameter(design.pinion)), float(highest_parameter(design.pinion))
    return np.linspace(low - BEYOND * (high - low), high + BEYOND * (high - low), DENSE)


def _at(row: FloatArray, z: FloatArray, wanted: float, start: int) -> float:
    """Find the z of a curve where a row of it has the wanted value, on the stretch around position `start`
    along which the row is monotone; NaN where it does not have it there."""
    steps = np.diff(row)
    if not np.isfinite(row[start]) or not np.isfinite(steps[start]):
        return np.nan
    away = np.flatnonzero(~(steps * steps[start] > 0.0))
    low = away[away < start].max(initial=-1) + 1
    high = away[away > start].min(initial=steps.size) + 1
    order = np.argsort(row[low:high]) + low
    return float(np.interp(wanted, row[order], z[order], left=np.nan, right=np.nan))


def concavity(design: Design, flank: str, size: float) -> dict[str, FloatArray]:
    """Say how concave parabola coefficients of +size and -size make the flanks (2 members, 2), against
    the involute one at mid-face: metal left near root and tip, the lesser for +size and the greater for
    -size, mm along the circle; and by how much the profile's curvature at l = 0 falls, 1/mm."""
    metal, curvature = np.empty((2, 2)), np.empty((2, 2))
    for j, member in enumerate(design.members):
        plain = replace(member, tool=replace(member.tool, parabola=0.0))
        for k, (sign, pick) in enumerate(((1.0, np.min), (-1.0, np.max))):
            bent = replace(member, tool=replace(member.tool, parabola=sign * size))
            _, added = added_metal(member, flank, sign * size)
            metal[j, k] = pick(added[near_ends(added.size)])
            curvature[j, k] = _profile_curvature(plain, flank) - _profile_curvature(bent, flank)
    return {"metal near root and tip": metal, "curvature of the profile": curvature}


def added_metal(member: Member, flank: str, parabola: float) -> tuple[FloatArray, FloatArray]:
    """Find the radii (n,) that the involute profile at mid-face and that with a parabola coefficient, 1/mm,
    both reach, root to tip, mm, and how much metal the coefficient leaves there (n,), mm along the circle."""
    plain, bent = (replace(member, tool=replace(member.tool, parabola=a)) for a in (0.0, parabola))
    (r, thick), (other_r, other_thick) = _profile(plain, flank), _profile(bent, flank)
    start = int(other_r.argmin())  # an undercut profile turns there
    other_r, other_thick = other_r[start:], other_thick[start:]
    both = ~((r < other_r[0]) | (r > other_r[-1]))
    return r[both], np.interp(r[both], other_r, other_thick) - thick[both]


def near_ends(count: int) -> list[int]:
    """Say which of so many points of a profile are near root and tip."""
    return [count // 20, count - 1 - count // 20]


def _profile(member: Member, flank: str) -> tuple[FloatArray, FloatArray]:
    """Find the radii (DENSE,), and how thick the tooth is there from its middle to the flank, mm, at
    mid-face."""
    l = np.linspace(float(root_parameter(member)), float(highest_parameter(member)), DENSE)
    point = flank_point(member, flank, l, trace_parameter(member, flank, l, 0.0))
    r = np.hypot(point[:, 0], point[:, 1])
    return r, r * half_thickness_angle(member, flank, l, 0.0)


def _profile_curvature(member: Member, flank: str) -> float:
    """Find the normal curvature (1/mm) of a flank across its trace at l = 0, mid-face; positive is convex."""
    u = trace_parameter(member, flank, 0.0, 0.0)
    step = flank_patch(member, flank, 0.0, u).tangent_l
    turn, _ = normal_rates(member, flank, 0.0, u)
    return float((turn * step).sum() / (step * step).sum())
