"""Intersection of flank and fillet of an undercut tooth.

In a plane z, the curve that the tool leaves rises from the bottom land along the fillet to a first cusp,
falls to a second cusp and rises along the flank to the tip. The tooth consists of the lower rising branch
up to its intersection with the upper one, and of the upper branch above. Near the beginning of undercut,
let t be the roll angle of the involute from its cusp and -e that of the joint. The flank then starts at
t = e / 2, so that the lost length is proportional to the depth of undercut.

Steps: bracket the cusps by the sign of d(r^2)/ds and compute them, then solve for both profile coordinates by
Newton's method, starting from this limit or from the series through fewer planes. Where this fails, scan the
upper branch for the sign of the angle between the branches at equal radii, and repeat inside the bracket.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray, Mask
from .crossing_curve import RADIUS, CrossingCurve, FacePart, curve_nodes, face_part
from .tooth_surface import ToothSurface, cut_at, radius_square

SCAN_POINTS = 65
"""Number of points of a branch at which a sign is evaluated."""
BRACKET_PITCH_RADII = 1e-15
"""Width of the bracket of a root, relative to the pitch radius, at which the iteration ends."""


def crossing_of(surface: ToothSurface) -> tuple[CrossingCurve | None, bool]:
    """Return the curve on which flank and fillet of a folded surface intersect, and whether undercut leaves
    no flank in a part of the face. The curve is None in this case.
    """
    # Fractions of half the face width by which the curve is continued beyond toe and heel. The first
    # one with which flank is left in all planes is used.
    face_continuations = (0.3, 0.0)
    half = surface.half_width
    for continued in face_continuations:
        result = [_part(surface, *ends) for ends in _folded_parts(surface, half * (1.0 + continued))]
        parts = tuple(part for part in result if part is not None)
        if len(parts) == len(result):
            return CrossingCurve(parts), False
    return None, True


def _folded_parts(surface: ToothSurface, half: float) -> list[tuple[float, float, tuple[bool, bool]]]:
    """Return the ends (mm) of the undercut parts of a face, and whether undercut begins at each of them."""
    # Number of planes along the face in which the beginning of undercut is searched.
    face_planes = 33
    z = half * np.linspace(-1.0, 1.0, face_planes)
    folded = np.concatenate(([False], _least_rise(surface, z) <= 0.0, [False]))
    edges = np.flatnonzero(folded[1:] != folded[:-1]).reshape(-1, 2)
    parts, exact = [], BRACKET_PITCH_RADII * surface.pitch_radius
    for first, last in edges.tolist():
        # Undercut begins between the outermost undercut plane and the sound plane next to it, if any.
        onset = first > 0, last < face_planes
        inside, outside = z[[first, last - 1]], z[[max(first - 1, 0), min(last, face_planes - 1)]]
        edge = _root(lambda at: _least_rise(surface, at), inside, outside, exact)
        low, high = np.where(onset, edge, inside).tolist()
        if high > low:
            parts.append((low, high, onset))
    return parts


def _least_rise(surface: ToothSurface, z: FloatArray) -> FloatArray:
    """Return the least d(r^2)/ds (n,), mm, along the profile in the planes; not positive if undercut."""
    s = np.concatenate(_profiles(surface))
    return np.asarray(cut_at(surface, s[:, None] + 0.0 * z, z).square_s.min(axis=0))


def _profiles(surface: ToothSurface) -> tuple[FloatArray, FloatArray]:
    """Return the profile coordinates (mm) of the points of fillet and flank at which signs are evaluated."""
    low, joint = surface.bottom, surface.joint
    fillet = low + (joint - low) * np.linspace(0.02, 1.0, SCAN_POINTS)[:-1]
    # Without a parabola, d(r^2)/ds is linear along the flank.
    return fillet, np.linspace(joint, surface.highest, SCAN_POINTS if surface.parabola else 2)


def _root(
    function: Callable[[FloatArray], FloatArray], one: FloatArray, other: FloatArray, accuracy: float
) -> FloatArray:
    """Return roots (n,) of a function between two values, to `accuracy`, by Chandrupatla's method: inverse
    quadratic interpolation inside a bracket, or bisection where this is not safe. NaN where the signs do not
    differ.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        x, far, f, f_far = one, other, function(one), function(other)
        x, share = np.where((f > 0.0) != (f_far > 0.0), x, np.nan), f / (f - f_far)
        for _ in range(60):
            following = x + share * (far - x)
            value = function(following)
            # Keep the end with the other sign. The third point is the end that is dropped.
            same = (value > 0.0) == (f > 0.0)
            last, f_last = np.where(same, x, far), np.where(same, f, f_far)
            far, f_far = np.where(same, far, x), np.where(same, f_far, f)
            x, f = following, value
            xi, phi = (x - far) / (last - far), (f - f_far) / (f_last - f_far)
            smooth = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
            inverse = f / (f_far - f) * f_last / (f_far - f_last)
            inverse = inverse + (last - x) / (far - x) * f / (f_last - f) * f_far / (f_last - f_far)
            # End where the bracket or the next step is small.
            least = accuracy / np.abs(far - x)
            unsolved = (least < 0.5) & (f != 0.0) & ~(smooth & (np.abs(inverse) < least))
            if not unsolved.any():
                break
            share = np.minimum(np.maximum(np.where(smooth, inverse, 0.5), least), 1.0 - least)
            share = np.where(unsolved, share, 0.0)
    return x


def _part(surface: ToothSurface, low: float, high: float, onset: tuple[bool, bool]) -> FacePart | None:
    """Return an undercut part of the face; None if no flank is left."""
    # Numbers of planes for the series; the first one that resolves the curve is used.
    series_planes = (12, 16, 24, 32, 48, 64)
    # Convergence limit of the last coefficients, relative to the pitch radius.
    series_tolerance = 1e-14
    part = near = None
    # Increase the number of planes until the series is resolved.
    for count in series_planes:
        z = 0.5 * (low + high) + 0.5 * (high - low) * curve_nodes(count)
        if part is not None:
            near = part.rows(z)[:RADIUS, 0]
        values = intersections(surface, z, near)
        if np.isnan(values).any():
            return None
        part = face_part(low, high, values, onset, surface.bottom)
        # Near the cusp, rounding errors of the profile coordinate exceed those of the radius.
        if np.abs(part.series[1:3, -2:]).max() <= series_tolerance * surface.pitch_radius:
            break
    return part


def intersections(surface: ToothSurface, z: FloatArray, near: FloatArray | None = None) -> FloatArray:
    """Return `start`, `end` and radius (3, n), mm, in undercut planes; NaN if flank and fillet do not
    intersect below the tip. `near` (2, n) are estimates of `start` and `end`, mm.
    """
    # Distance of joint and cusp, relative to the pitch radius, below which the flank starts at 1.5
    # times this distance.
    slight_undercut = 3e-5
    with np.errstate(invalid="ignore", divide="ignore"):
        top, cusp = _cusps(surface, z)
        # Next to the beginning of undercut, the angle between fillet and flank is below rounding. The limit
        # t = e / 2 of the module docstring is exact there.
        slight = (top == surface.joint) & (cusp - top < slight_undercut * surface.pitch_radius)
        place, at, left = np.full((2, z.size), np.nan), *map(np.flatnonzero, (slight, ~slight & (cusp > top)))
        if at.size:
            nearly = top[at] + 1.5 * (cusp[at] - top[at])
            below = fillet_profile(surface, cut_at(surface, nearly, z[at]).square, z[at], top[at])
            place[:, at] = nearly, np.where(np.isnan(below), top[at], below)
        if left.size:
            place[:, left] = _crossings(
                surface, z[left], top[left], cusp[left], None if near is None else near[:, left]
            )
        radius = np.sqrt(cut_at(surface, place[1], z).square)
    tip = surface.tip + surface.taper * z
    return np.where(radius < tip, np.array((*place, radius)), np.nan)


def _cusps(surface: ToothSurface, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the profile coordinates (n,) of the first cusp above the bottom land, usually the joint, and of
    the last cusp below the tip, NaN without one.
    """

    def rise(s: FloatArray, planes: FloatArray = z) -> FloatArray:
        return cut_at(surface, s, planes).square_s

    fillet, flank = _profiles(surface)
    s, exact = np.append(fillet, flank), BRACKET_PITCH_RADII * surface.pitch_radius
    rises = rise(s[:, None] + 0.0 * z) > 0.0
    # The first cusp is the joint, or on the fillet.
    first = np.maximum((~rises).argmax(axis=0), 1)
    top, at = s[first], np.flatnonzero(s[first] != surface.joint)
    if at.size:
        top[at] = _root(lambda s: rise(s, z[at]), s[first[at] - 1], s[first[at]], exact)
    # The last cusp is on the flank.
    rises = rises[fillet.size :]
    last = flank.size - 1 - np.maximum((~rises[::-1]).argmax(axis=0), 1)
    return top, _root(rise, flank[last], flank[last + 1], exact)


def _crossings(
    surface: ToothSurface, z: FloatArray, top: FloatArray, cusp: FloatArray, near: FloatArray | None
) -> FloatArray:
    """Return both profile coordinates (2, n), mm, of the intersections between the cusps, NaN without one.
    `near` are estimates of them.
    """
    # Distance from the joint, relative to `ToothSurface.scale`, at which the slope of the fillet is
    # computed.
    tangent_distance = 1e-6
    # Range of the first scan, relative to the part of the flank below the first cusp.
    scan_excess = 1.2
    # Maximum number of scans, each in the bracket of the one before; the first one is usually
    # sufficient.
    scans = 3
    bottom, highest = surface.bottom + 0.0 * z, surface.highest + 0.0 * z
    least, goal, most = cut_at(surface, np.array((cusp, top, highest)), z).square
    # The flank reaches the radius of the first cusp: without a parabola, r^2 is quadratic in s.
    lens = np.minimum(np.sqrt((goal - least) / (most - least)), 1.0) * (highest - cusp)
    ends = np.array((cusp, np.minimum(cusp + scan_excess * lens, highest)))
    if near is None:
        # Near the beginning of undercut, the flank starts in the middle of this part, where r^2 has a quarter
        # of its increase. The fillet is estimated by its tangent at the first cusp.
        edge = cut_at(surface, top - tangent_distance * surface.scale, z)
        near = np.array((cusp + 0.5 * lens, top - 0.75 * (goal - least) / edge.square_s))
    place, good = _newton(surface, near, np.array(((cusp, bottom), (ends[1], top))), lens, z)
    # If Newton's method fails, scan the flank for a bracket.
    left = np.flatnonzero(~good)
    for _ in range(scans if left.size else 0):
        bounds = _scanned(surface, z[left], top[left], ends[:, left])
        place[:, left], good = _newton(surface, bounds.mean(axis=0), bounds, lens[left], z[left])
        if good.all():
            break
        ends[:, left], left = bounds[:, 0], left[~good]
    return place


def _scanned(surface: ToothSurface, z: FloatArray, top: FloatArray, ends: FloatArray) -> FloatArray:
    """Return brackets (2, 2, n) of the intersection: the lower and upper profile coordinates on the flank,
    between `ends` (2, n), and on the fillet, mm; NaN where there is none. Below the intersection, the flank
    is inside the removed material.
    """
    s = ends[0] + (ends[1] - ends[0]) * np.linspace(0.0, 1.0, SCAN_POINTS)[:, None]
    plane = np.broadcast_to(z, s.shape)
    flank = cut_at(surface, s, plane)
    below = fillet_profile(
        surface, flank.square.ravel(), plane.ravel(), np.broadcast_to(top, s.shape).ravel()
    ).reshape(s.shape)
    fillet = cut_at(surface, below, plane)
    apart = _apart(*np.array(((flank.x, fillet.x), (flank.y, fillet.y), (flank.phi, fillet.phi))))
    outside = surface.sigma * apart
    inside = outside < 0.0
    place = SCAN_POINTS - 1 - inside[::-1].argmax(axis=0)
    result = inside.any(axis=0) & (place < SCAN_POINTS - 1)
    place, each = np.minimum(place, SCAN_POINTS - 2), np.arange(z.size)
    both = np.array((place, place + 1))
    # By rounding, the fillet may have no point at the radius of the first cusp.
    above = np.where(np.isnan(below), top, below)
    return np.where(result, np.stack((s[both, each], above[both, each]), axis=1), np.nan)


def _apart(x: FloatArray, y: FloatArray, phi: FloatArray) -> FloatArray:
    """Return angles (rad) about the axis from points of a flank to points of a fillet, given by their x, y
    and phi (2, ...).
    """
    cos, sin = x[0] * x[1] + y[0] * y[1], x[0] * y[1] - y[0] * x[1]
    return np.asarray(phi[1] - phi[0] + np.arctan2(sin, cos))


def _newton(
    surface: ToothSurface, place: FloatArray, bounds: FloatArray, lens: FloatArray, z: FloatArray
) -> tuple[FloatArray, Mask]:
    """Return both profile coordinates (2, n) at which radii and angles are equal, by Newton's method clipped
    to `bounds` (2, 2, n), and whether the iteration has converged. NaN bounds count as converged.

    `lens` (n,), mm, is the length of the flank from its cusp to the radius of the first cusp.
    """
    # Newton step, relative to the flank up to the radius of the first cusp, below which the iteration
    # ends: the error is about its square.
    last_newton_step = 1e-6
    # Angle (rad) between the branches, and relative difference of their r^2, at which only rounding is
    # left.
    rounding_error = 4e-16
    good, enough = np.isnan(bounds).any(axis=(0, 1)), last_newton_step * lens
    for _ in range(12):
        cut = cut_at(surface, place, z)
        square, rise = cut.square, 0.5 * cut.square_s
        turn = cut.phi_s + (cut.x * cut.y_s - cut.y * cut.x_s) / square
        missing = 0.5 * (square[1] - square[0]), _apart(cut.x, cut.y, cut.phi)
        # Cramer's rule for rise_0 d_0 - rise_1 d_1 = missing_0 and turn_0 d_0 - turn_1 d_1 = missing_1.
        first = rise[1] * missing[1] - turn[1] * missing[0]
        second = rise[0] * missing[1] - turn[0] * missing[0]
        step = np.array((first, second)) / (rise[1] * turn[0] - rise[0] * turn[1])
        place = np.minimum(np.maximum(place + step, bounds[0]), bounds[1])
        rounding = np.maximum(np.abs(missing[0]) / square[0], np.abs(missing[1])) <= rounding_error
        good = good | rounding | (np.abs(step) <= enough).all(axis=0)
        if good.all():
            break
    return place, np.asarray(good)


def fillet_profile(surface: ToothSurface, square: FloatArray, z: FloatArray, top: FloatArray) -> FloatArray:
    """Return the profile coordinate of points with r^2 = `square` (mm^2) in the planes `z` on the fillet up
    to `top` (mm), by Newton's method inside a bracket; NaN outside. Arrays of one axis.
    """
    # Newton step, relative to the branch, below which the iteration ends: the error is its square.
    last_fillet_step = 1e-8
    low, high = np.full_like(z, surface.bottom), top
    floor, most = radius_square(surface, np.concatenate((low, high)), np.tile(z, 2))[0].reshape(2, -1)
    share = (square - floor) / (most - floor)
    slack = 1e-12
    s = surface.bottom + (top - surface.bottom) * np.sqrt(np.clip(share, 0.0, 1.0))
    for _ in range(80):
        reached, rate = radius_square(surface, s, z)
        excess = reached - square
        above = excess > 0.0
        low, high = np.where(above, low, s), np.where(above, s, high)
        following = s - excess / rate
        following = np.where((following >= low) & (following <= high), following, 0.5 * (low + high))
        step, s = following - s, following
        if not (np.abs(step) > last_fillet_step * surface.scale).any():
            break
    return np.where((share >= -slack) & (share <= 1.0 + slack), s, np.nan)
