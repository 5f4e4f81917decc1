"""All curves of contact of a pair in a window of flank parameters, found and traced.

`curves_of` samples F for both signs of n_x along a grid of lines in (l1, l2) that covers both flanks and a
margin. Every change of sign along a line is a point of a curve of contact. From these points the curve is
traced in both directions by its length (`curve_equations`), by predictor and corrector steps, until it closes
or leaves the window: slightly beyond root and tip in l1 and l2, and MAX_DISTANCE_FACES along the axes. Points
on a traced curve need no further trace. A trace that rounding stops, and a change of sign that no trace
explains, are `lost`.

A curve is not found if it stays between the lines of the grid, which are 1/29 of a flank depth apart, or if
it crosses them only twice between two samples.

All cases are traced together, since a step costs little more for many cases than for one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from ...gear.rack import rack_normal
from ..equation import axial_and_radius, gap_of, guarded_gap, meet, relative_margins
from ..flank_pair import FlankPair, MemberTerms, terms_of_one
from .curve_equations import direction_of, linearised, meet_on_curve, onto_curve, units_of
from .root_exclusion import window_of

MAX_DISTANCE_FACES = 1e4
"""Distance from mid-face, in face widths, up to which a curve is traced. If the generators are nearly
parallel or the parabolas strong, l1 and l2 hardly change along the curve, and it meets the next grid line
only there.
"""
NEWTON_STEPS = 5
OFF_FLANK_MARGIN = 0.1
"""Distance beyond a limit, in flank depths or face widths, from which a point is off the flanks."""
LONGEST_STEP = 0.08
"""Longest step along the curve near the faces, in units of z."""

Window: TypeAlias = tuple[FloatArray, FloatArray]
"""Bounds (2, cases, 1) in l1 and l2, mm."""


@dataclass(frozen=True, eq=False)
class TracedCurve:
    """One curve of contact of one case: points z (points, 4) in order, and whether it is closed or was lost
    before it left the window.
    """

    case: int
    points: FloatArray
    closed: bool
    lost: bool


@dataclass(frozen=True, eq=False)
class CurvePart:
    """Part of a traced curve near the flanks: its case, z (points, 4), and whether it closes on itself
    without meeting a limit.
    """

    case: int
    points: FloatArray
    endless: bool


def curves_of(pairing: FlankPair, near: Window | None = None) -> tuple[list[TracedCurve], Mask]:
    """Return all curves of contact in the window, and for which cases a sampled normal does not exist.

    `near`: bounds (2, cases, 1) in l1 and l2, mm, of all contacts near the faces. The grid then covers only
    these bounds, and curves are traced only up to a face width from mid-face.
    """
    # Distance, in steps, from the line through the points of a traced curve within which a point is on
    # the curve. The steps rotate so little that the actual distance is five times smaller.
    same_curve_steps = 0.06
    near_distance_faces = 1.0
    units, farthest = units_of(pairing), MAX_DISTANCE_FACES if near is None else near_distance_faces
    window = window_of(pairing) if near is None else near
    case, z, solved, missing = _points_on_curves(pairing, units, window, farthest)
    untouched = np.ones(case.size, dtype=bool)
    curves: list[TracedCurve] = []
    # Trace from one untouched point per case, and mark the points that lie on the traced curve.
    for _ in range(40):
        left = np.flatnonzero(untouched & solved)
        cases, first = np.unique(case[left], return_index=True)
        if cases.size == 0:
            break
        start = left[first]
        for curve in _traced_both_ways(pairing.cases(cases), units[cases], z[start], cases, farthest):
            curves.append(curve)
            mine = np.flatnonzero(untouched & (case == curve.case))
            untouched[mine[_distance(z[mine], curve.points) < same_curve_steps]] = False
        untouched[start] = False
    # Points that no trace explains are lost curves.
    lost = np.unique(case[untouched])
    curves += [TracedCurve(k, z[untouched & (case == k)], False, True) for k in lost.tolist()]
    return curves, missing


def _points_on_curves(
    pairing: FlankPair, units: FloatArray, window: Window, farthest: float
) -> tuple[Integers, FloatArray, Mask, Mask]:
    """Return points of curves on lines of constant l1 and of constant l2.

    The results are their cases, z (points, 4), which are solved to rounding, and for which cases some sample
    has no common normal.
    """
    result, missing = [], np.zeros(pairing.branch.shape[0], dtype=bool)
    for member in range(2):
        l = _lines(pairing, member, window)
        terms = _terms_on_lines(pairing, l, member)
        # Both signs of n_x.
        for sheet in (1.0, -1.0):
            part = replace(pairing, branch=np.full(pairing.branch.shape, sheet))
            met = gap_of(part, *terms)
            gap = guarded_gap(part, met).reshape(l.shape[1:])
            real = ~np.isnan(met.gap).reshape(l.shape[1:])
            # A change of sign is a point of a curve, or the pole where F is real on one side.
            hit = (np.signbit(gap[..., :-1]) != np.signbit(gap[..., 1:])) & (real[..., :-1] | real[..., 1:])
            sides = np.stack((l[..., :-1][:, hit], l[..., 1:][:, hit]))
            result.append((np.nonzero(hit)[0], np.full(sides.shape[-1], sheet), sides, gap[..., :-1][hit]))
        missing |= ~real.all(axis=(1, 2, 3))
    case, branch, sides, side = (np.concatenate(parts, axis=-1) for parts in zip(*result, strict=True))
    part, units = replace(pairing.cases(case), branch=branch[:, None]), units[case]
    z, solved = np.full((case.size, 1, 4), np.nan), np.zeros(case.size, dtype=bool)
    # Bisect, then solve by Newton's method; bisect further where this fails to reach rounding, as near
    # n_x = 0.
    for halvings in (12, 50):
        left = np.flatnonzero(~solved)
        z[left], solved[left] = _solved_between(
            part.cases(left), units[left], sides[..., left, None], side[left, None], halvings
        )
    inside, _ = _within(part, z, units, farthest)
    return case[inside], z[inside, 0], solved[inside], missing


def _lines(pairing: FlankPair, member: int, window: Window) -> FloatArray:
    """Return samples l (2, cases, lines, segments, samples), mm, on lines through a window
    along which l of `member` varies and the other l is constant.

    Each line is divided where n_x vanishes, and samples are concentrated quadratically towards these points:
    F is smooth in n_x, and n_x varies with the square root of the distance in l.
    """
    low, high = window
    # Grid lines of each member, and samples on each segment of a line.
    grid_lines, samples_per_segment = 33, 17
    fixed = low + np.linspace(0.0, 1.0, grid_lines) * (high - low)
    v = rack_normal(pairing.rack, fixed)[2, 1 - member]
    rack, layout = pairing.rack, pairing.layout
    # v_j = R cos(tau + psi) with tan(tau) = 2 a l; n_x vanishes where v_j is one of the two `edges`.
    normal, direction = rack.normal[2, member], rack.direction[2, member]
    edges = (
        -v * layout.cos_angle + sign * np.sqrt(1.0 - v * v) * np.abs(layout.sin_angle) for sign in (-1.0, 1.0)
    )
    turns = [np.arccos(edge / np.hypot(normal, direction)) for edge in edges]
    psi = np.arctan2(direction, normal)
    bend = 2.0 * np.broadcast_to(rack.parabola, (2, *v.shape[:1], 1))[member]
    cuts = [np.tan(sign * turn - psi) / bend for turn in turns for sign in (-1.0, 1.0)]
    least, most = low[member], high[member]
    cuts = [np.where(np.isnan(cut), least, np.clip(cut, least, most)) for cut in cuts]
    ends = np.broadcast_arrays(least, *cuts, most)
    breaks = np.sort(np.stack(ends, axis=-1), axis=-1)
    # Move segments of length zero to the end and drop those that no line needs.
    length = np.diff(breaks, axis=-1)
    first = np.argsort(length == 0.0, axis=-1, kind="stable")
    first = first[..., : max(1, int((length > 0.0).sum(axis=-1).max(initial=1)))]
    start, length = (np.take_along_axis(x, first, axis=-1)[..., None] for x in (breaks, length))
    # Cosine spacing concentrates the samples at both ends of a segment.
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, samples_per_segment))
    varied = start + share * length
    l = np.empty((2, *varied.shape))
    l[member], l[1 - member] = varied, fixed[1 - member][..., None, None]
    return l


def _terms_on_lines(pairing: FlankPair, l: FloatArray, member: int) -> tuple[MemberTerms, MemberTerms]:
    """Return terms of pinion and gear at samples l (2, cases, lines, segments, samples), mm, on one axis of
    positions.
    """
    _, cases, _, pieces, samples = l.shape
    varied = terms_of_one(pairing, l[member].reshape(cases, -1), member)
    once = terms_of_one(pairing, l[1 - member, :, :, 0, 0], 1 - member)
    fixed = MemberTerms(
        **{name: np.repeat(value, pieces * samples, axis=-1) for name, value in vars(once).items()}
    )
    return (fixed, varied) if member else (varied, fixed)


def _solved_between(
    part: FlankPair, units: FloatArray, sides: FloatArray, side: FloatArray, halvings: int
) -> tuple[FloatArray, Mask]:
    """Return points z (points, 1, 4) of curves between `sides` (2, 2, points, 1), and which are solved. The
    others are only bisected, NaN without a common normal.
    """
    start = _bisected(part, sides, side, halvings).T[:, None] / units
    tangent = direction_of(linearised(part, start, units)[1])
    z, solved = onto_curve(part, start, tangent, units, NEWTON_STEPS)
    solved &= np.linalg.norm(z - start, axis=-1) < LONGEST_STEP
    return np.where(solved[..., None], z, start), solved[:, 0]


def _bisected(part: FlankPair, ends: FloatArray, gap: FloatArray, halvings: int) -> FloatArray:
    """Return points y (4, points) near the change of sign of F between `ends` (2, 2, points, 1).

    `gap` has the sign of F at the first end. NaN if neither side has a common normal.
    """
    near, far = ends
    for _ in range(halvings):
        between = 0.5 * (near + far)
        pinion, gear = (terms_of_one(part, between[member], member) for member in (0, 1))
        same = np.signbit(guarded_gap(part, gap_of(part, pinion, gear))) == np.signbit(gap)
        near, far = np.where(same, between, near), np.where(same, far, between)
    y = np.full((4, gap.shape[0]), np.nan)
    for l in (near, far):
        met = meet(part, l)
        y = np.where(np.isnan(y), np.array((*l, met.normal_x, met.across[0]))[..., 0], y)
        y[:, np.isnan(y).any(axis=0)] = np.nan
    return y


def _within(pairing: FlankPair, z: FloatArray, units: FloatArray, farthest: float) -> tuple[Mask, FloatArray]:
    """Return whether points (cases, 1, 4) are in the window, up to `farthest`, and their distance from
    mid-face along the axes of both members, (cases, 2), in face widths.
    """
    y = np.moveaxis(z * units, -1, 0)
    axial, _ = axial_and_radius(pairing, meet_on_curve(pairing, y)[1])
    faces = (axial / (2.0 * pairing.half_width))[..., 0].T
    low, high = window_of(pairing)
    inside = np.all((y[:2] >= low) & (y[:2] <= high), axis=0)[:, 0] & (np.abs(faces) <= farthest).all(axis=-1)
    return np.asarray(inside), np.asarray(faces)


def _distance(z: FloatArray, line: FloatArray) -> FloatArray:
    """Return distances (points) of z (points, 4) from a line through points (corners, 4), in segments of the
    line if these are longer than LONGEST_STEP, else in LONGEST_STEP.
    """
    if len(line) < 2:
        return np.asarray(np.linalg.norm(z - line[0], axis=-1)) / LONGEST_STEP
    side = np.diff(line, axis=0)
    from_corner = z[:, None] - line[:-1]
    share = np.einsum("pci,ci->pc", from_corner, side) / np.einsum("ci,ci->c", side, side)
    foot = from_corner - np.clip(share, 0.0, 1.0)[..., None] * side
    size = np.maximum(np.linalg.norm(side, axis=-1), LONGEST_STEP)
    return np.asarray((np.linalg.norm(foot, axis=-1) / size).min(axis=-1))


def _traced_both_ways(
    pairing: FlankPair, units: FloatArray, start: FloatArray, names: Integers, farthest: float
) -> list[TracedCurve]:
    """Return the curves through `start` (cases, 4), one per case; `names` are the numbers of the cases."""
    twice = np.tile(np.arange(len(names)), 2)
    pairing, units, z = pairing.cases(twice), units[twice], start[twice]
    tangent = direction_of(linearised(pairing, z[:, None], units)[1])[:, 0]
    tangent[len(names) :] *= -1.0
    lines, closes, lost = _trace(pairing, units, z, tangent, farthest)
    curves = []
    for k, name in enumerate(names.tolist()):
        ahead, back = lines[k], lines[k + len(names)]
        points = ahead if closes[k] else np.concatenate((back[:0:-1], ahead))
        curves.append(TracedCurve(name, points, bool(closes[k]), bool(lost[[k, k + len(names)]].any())))
    return curves


def _trace(
    pairing: FlankPair, units: FloatArray, start: FloatArray, tangent: FloatArray, farthest: float
) -> tuple[list[FloatArray], Mask, Mask]:
    """Return the points of traces from `start` (traces, 4) along `tangent`, and which of them close or are
    lost. The others leave the window.
    """
    # Largest step along the axis of either member near its face, in face widths.
    max_axial_step_faces = 0.2
    z, first, (_, faces) = start.copy(), tangent, _within(pairing, start[:, None], units, farthest)
    # First and shortest step along the curve, in units of z.
    first_step, shortest_step, most_steps = 0.02, 1e-7, 3000
    # Cosine of the rotation of the tangent below which the steps do not grow.
    growth_turn_cosine = 0.998
    step, faces = first_step * _far(faces).max(axis=-1), faces.copy()
    tangent, taken = tangent.copy(), np.zeros(len(start), dtype=int)
    closes, lost = np.zeros(len(start), dtype=bool), np.ones(len(start), dtype=bool)
    active, steps = np.arange(len(start)), [start.copy()]
    for _ in range(most_steps):
        # Predictor and corrector step of all active traces.
        part, far = pairing.cases(active), _far(faces[active])
        ahead, turned, cosine, good = _one_step(part, units[active], z[active], tangent[active], step[active])
        inside, reached = _within(part, ahead[:, None], units[active], farthest)
        good &= (np.abs(reached - faces[active]) < max_axial_step_faces * far).all(axis=-1)
        moved = active[good]
        z[moved], tangent[moved], faces[moved] = ahead[good], turned[good], reached[good]
        taken[moved] += 1
        reached = np.full(z.shape, np.nan)
        reached[moved] = z[moved]
        steps.append(reached)
        # Step size control: grow on straight parts, halve after a rejected step.
        most = LONGEST_STEP * _far(faces[active]).max(axis=-1)
        longer = np.where(cosine > growth_turn_cosine, np.minimum(1.5 * step[active], most), step[active])
        step[active] = np.where(good, np.minimum(longer, most), 0.5 * step[active])
        # A trace is closed if it returns to its start in the same direction.
        home = np.linalg.norm(z[active] - start[active], axis=-1) < step[active]
        home &= np.einsum("...i,...i", tangent[active], first[active]) > 0.5
        outside, closed = good & ~inside, good & home & (taken[active] > 4)
        lost[active[outside | closed]], closes[active[closed]] = False, True
        steps[-1][active[closed]] = start[active[closed]]
        active = active[~(outside | closed | (step[active] < shortest_step))]
        if active.size == 0:
            break
    history = np.stack(steps)
    return [history[~np.isnan(history[:, k, 0]), k] for k in range(len(start))], closes, lost


def _far(faces: FloatArray) -> FloatArray:
    """Return the factor by which steps may be longer than near the flanks, for each member."""
    growth_per_face_width = 4.0
    return np.asarray(np.maximum(1.0, growth_per_face_width * (np.abs(faces) - 1.0)))


def _one_step(
    part: FlankPair, units: FloatArray, z: FloatArray, tangent: FloatArray, step: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, Mask]:
    """Return points and tangents after a step, cosines of the rotation, and whether the steps are accepted.

    In long steps far from the faces w1 has less weight: l1, l2 and n_x distinguish one curve from the next.
    """
    predicted = (z + step[:, None] * tangent)[:, None]
    ahead, solved = onto_curve(part, predicted, tangent[:, None], units, NEWTON_STEPS)
    turned = direction_of(linearised(part, ahead, units)[1])[:, 0]
    # w1 has less weight in long steps.
    weight = np.ones(z.shape)
    weight[:, 3] = np.minimum(1.0, LONGEST_STEP / step)
    before, after = weight * tangent, weight * turned
    size = np.linalg.norm(before, axis=-1) * np.linalg.norm(after, axis=-1)
    cosine = np.einsum("...i,...i", after, before) / size
    drift = np.linalg.norm(weight * (ahead - predicted)[:, 0], axis=-1)
    moved = np.linalg.norm(weight * (ahead[:, 0] - z), axis=-1)
    # Accept a step if the tangent turns little and the point is near the prediction.
    least_turn_cosine, max_drift_steps = 0.995, 0.3
    good = (
        solved[:, 0]
        & (np.abs(cosine) > least_turn_cosine)
        & (drift < max_drift_steps * moved)
        & (moved < 2.0 * LONGEST_STEP)
    )
    return ahead[:, 0], np.copysign(1.0, cosine)[:, None] * turned, np.abs(cosine), good


def near_flanks(pairing: FlankPair, curves: list[TracedCurve]) -> list[CurvePart]:
    """Return the parts of curves that may be on the flanks, with a margin at both ends."""
    if not curves:
        return []
    case = np.concatenate([np.full(len(curve.points), curve.case) for curve in curves])
    part = pairing.cases(case)
    y = np.concatenate([curve.points for curve in curves])[:, None] * units_of(part)
    y = np.moveaxis(y, -1, 0)
    met = meet_on_curve(part, y)[1]
    (axial, _), margins = axial_and_radius(part, met), relative_margins(part, y[:2], met)[..., 0]
    # Half face widths beyond toe and heel to which a part reaches.
    part_margin_half_widths = 0.5
    near = np.all(np.abs(axial) <= (1.0 + part_margin_half_widths) * part.half_width, axis=0)[:, 0]
    parts, start = [], 0
    for curve in curves:
        here = slice(start, start + len(curve.points))
        parts += _cut(curve, near[here], margins[:, here])
        start = here.stop
    return parts


def _cut(curve: TracedCurve, near: Mask, margins: FloatArray) -> list[CurvePart]:
    """Return the parts of one curve around its points that are `near` the flanks, except for parts that are
    off the flanks by the `margins` (8, points) of the points."""
    points = curve.points
    if curve.closed:  # begin at the point furthest outside
        order = np.roll(np.arange(len(points) - 1), -int(margins[:, :-1].min(axis=0).argmin()))
        order = np.append(order, order[0])
        points, near, margins = points[order], near[order], margins[:, order]
        if margins.min() > 0.0:
            return [CurvePart(curve.case, points, True)]
    # Runs of near points, with two more points at both ends; drop runs clearly beyond one limit.
    edges = np.flatnonzero(np.diff(np.concatenate(([0], near, [0]))))
    parts = []
    for first, last in edges.reshape(-1, 2):
        run = slice(max(first - 2, 0), last + 2)
        near_limits = (margins[:, first:last].max(axis=1) > -OFF_FLANK_MARGIN).all()
        if near_limits and (curve.lost or len(points[run]) > 1):
            parts.append(CurvePart(curve.case, points[run], False))
    return parts
