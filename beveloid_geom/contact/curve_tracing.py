"""All curves of contact of a pair in a window of flank parameters, found and traced.

`curves_of` samples F for both signs of n_x along a grid of lines in (l1, l2) that covers both flanks and a
little more. Every change of sign along a line is a point of a curve of contact, whatever else the
curve does between. From one such point after the other the curve is traced both ways
by its length (`curve_equations`), predictor and corrector, until it closes or leaves the window: in l1 and l2
a little beyond root and tip, along the axes FARTHEST. Points met on the way need no trace of their own; a
trace that rounding stops, and a change of sign that no trace explains, are `lost`.

What is left out is a curve that stays between the lines of the grid, 1/29 of a flank's depth apart, or
crosses them only twice between two samples.

All cases are traced in step, so that a step costs little more for many than for one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..gear.rack import rack_normal
from .cells import window_of
from .curve_equations import direction_of, linearised, meet_on_curve, onto_curve, units_of
from .equation import (
    Pairing,
    Terms,
    axial_and_radius,
    facing,
    guarded_gap,
    limit_margins,
    meet,
    terms_of_one,
)

LINES, SAMPLES = 33, 17
"""Lines of the grid for each member, and samples on each piece of a line."""
FARTHEST = 1e4
"""How far from mid-face, in face widths, a curve is traced. Where the generators are nearly parallel or the
parabolas strong, l1 and l2 hardly change along it, and it meets the next line of the grid only there."""
NEARBY = 1.0
"""The same where cells (`cells`) hold all contacts near the faces, and only these are asked for."""
HALVINGS, PASSES = (12, 50), 5
"""Of a change of sign before Newton, where it fails to rounding, as near n_x = 0; passes of Newton."""
FIRST_STEP, LONGEST, SHORTEST, GROWTH = 0.02, 0.08, 1e-7, 4.0
"""Steps along the curve, in units of z. More than a face width from mid-face LONGEST grows by GROWTH a face
width."""
ONWARD = 0.2
"""Face widths along the axis of either member that a step near its face may take."""
TURN, BEND, DRIFT = 0.995, 0.998, 0.3
"""Cosines of the turn of the tangent in a step: allowed, and below which the steps do not grow;
allowed distance of predicted from solved point, in steps."""
MOST_STEPS, MOST_TRACES = 3000, 40
OUTSIDE, SPARE = 0.5, 0.1
"""Half face widths beyond toe and heel to which a part of a curve reaches; depths, or face widths, by which a
limit must be missed all along for a part to count as off."""
SAME = 0.06
"""Distance, in steps, from the line through the points of a traced curve at which a point counts as lying
on it; the steps turn so little that the line is five times nearer."""

Window: TypeAlias = tuple[FloatArray, FloatArray]
"""Bounds (2, cases, 1) in l1 and l2, mm."""


class Stop(IntEnum):
    """Why a trace ended."""

    WINDOW = 0
    CLOSED = 1
    LOST = 2


@dataclass(frozen=True, eq=False)
class TracedCurve:
    """One curve of contact of one case: points z (points, 4) in order, and whether it is closed or
    was lost before it left the window."""

    case: int
    points: FloatArray
    closed: bool
    lost: bool


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a traced curve near the flanks: its case, z (points, 4), and whether it closes on
    itself without meeting a limit."""

    case: int
    points: FloatArray
    endless: bool


def curves_of(pairing: Pairing, near: Window | None = None) -> tuple[list[TracedCurve], NDArray[np.bool_]]:
    """Give all curves of contact in the window, and for which cases a sampled normal was missing.

    `near`: bounds (2, cases, 1) in l1 and l2, mm, that hold all contacts near the faces. The lines of the
    grid then cover but these, and curves are traced as far as NEARBY."""
    units, farthest = units_of(pairing), FARTHEST if near is None else NEARBY
    window = window_of(pairing) if near is None else near
    case, z, solved, missing = _points_on_curves(pairing, units, window, farthest)
    untouched = np.ones(case.size, dtype=bool)
    curves: list[TracedCurve] = []
    for _ in range(MOST_TRACES):
        left = np.flatnonzero(untouched & solved)
        cases, first = np.unique(case[left], return_index=True)
        if cases.size == 0:
            break
        start = left[first]
        for curve in _traced_both_ways(pairing.cases(cases), units[cases], z[start], cases, farthest):
            curves.append(curve)
            mine = np.flatnonzero(untouched & (case == curve.case))
            untouched[mine[_distance(z[mine], curve.points) < SAME]] = False
        untouched[start] = False
    lost = np.unique(case[untouched])
    return [
        *curves,
        *(TracedCurve(k, z[untouched & (case == k)], False, True) for k in lost.tolist()),
    ], missing


def _points_on_curves(
    pairing: Pairing, units: FloatArray, window: Window, farthest: float
) -> tuple[NDArray[np.int_], FloatArray, NDArray[np.bool_], NDArray[np.bool_]]:
    """Give points of curves on lines of constant l1 and of constant l2: their cases, z (points, 4), and which
    are solved to rounding; and for which cases some sample has no common normal."""
    found, missing = [], np.zeros(pairing.branch.shape[0], dtype=bool)
    for member in range(2):
        l = _lines(pairing, member, window)
        terms = _terms_on_lines(pairing, l, member)
        for sheet in (1.0, -1.0):
            part = replace(pairing, branch=np.full(pairing.branch.shape, sheet))
            met = facing(part, *terms)
            gap = guarded_gap(part, met).reshape(l.shape[1:])
            real = ~np.isnan(met.gap).reshape(l.shape[1:])
            hit = (np.signbit(gap[..., :-1]) != np.signbit(gap[..., 1:])) & (real[..., :-1] | real[..., 1:])
            sides = np.stack((l[..., :-1][:, hit], l[..., 1:][:, hit]))
            found.append((np.nonzero(hit)[0], np.full(sides.shape[-1], sheet), sides, gap[..., :-1][hit]))
        missing |= ~real.all(axis=(1, 2, 3))
    case, branch, sides, side = (np.concatenate(parts, axis=-1) for parts in zip(*found, strict=True))
    part, units = replace(pairing.cases(case), branch=branch[:, None]), units[case]
    z, solved = np.full((case.size, 1, 4), np.nan), np.zeros(case.size, dtype=bool)
    for halvings in HALVINGS:
        left = np.flatnonzero(~solved)
        z[left], solved[left] = _solved_between(
            part.cases(left), units[left], sides[..., left, None], side[left, None], halvings
        )
    inside, _ = _within(part, z, units, farthest)
    return case[inside], z[inside, 0], solved[inside], missing


def _lines(pairing: Pairing, member: int, window: Window) -> FloatArray:
    """Give samples l (2, cases, LINES, pieces, SAMPLES), mm, on lines through a window along which the l of
    `member` varies and that of the other does not.

    Each line is cut where n_x vanishes on it, and the samples crowd towards the cuts as their squares do:
    F is smooth in n_x, and runs to its pole with the root of the distance from the cut in l."""
    low, high = window
    fixed = low + np.linspace(0.0, 1.0, LINES) * (high - low)
    v = rack_normal(pairing.rack, fixed)[2, 1 - member]
    rack, layout = pairing.rack, pairing.layout
    # v_j = R cos(tau + psi) with tan(tau) = 2 a l; n_x vanishes where v_j is one of the two `edges`.
    normal, direction = rack.normal[2, member], rack.direction[2, member]
    edges = (
        -v * layout.cos_angle + sign * np.sqrt(1.0 - v * v) * np.abs(layout.sin_angle) for sign in (-1.0, 1.0)
    )
    turns = [np.arccos(edge / np.hypot(normal, direction)) for edge in edges]
    psi, bend = (
        np.arctan2(direction, normal),
        2.0 * np.broadcast_to(rack.parabola, (2, *v.shape[:1], 1))[member],
    )
    cuts = [np.tan(sign * turn - psi) / bend for turn in turns for sign in (-1.0, 1.0)]
    least, most = low[member], high[member]
    cuts = [np.where(np.isnan(cut), least, np.clip(cut, least, most)) for cut in cuts]
    ends = np.broadcast_arrays(least, *cuts, most)
    breaks = np.sort(np.stack(ends, axis=-1), axis=-1)
    length = np.diff(breaks, axis=-1)
    first = np.argsort(length == 0.0, axis=-1, kind="stable")
    first = first[..., : max(1, int((length > 0.0).sum(axis=-1).max(initial=1)))]
    start, length = (np.take_along_axis(x, first, axis=-1)[..., None] for x in (breaks, length))
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, SAMPLES))
    varied = start + share * length
    l = np.empty((2, *varied.shape))
    l[member], l[1 - member] = varied, fixed[1 - member][..., None, None]
    return l


def _terms_on_lines(pairing: Pairing, l: FloatArray, member: int) -> tuple[Terms, Terms]:
    """Give terms of pinion and gear at samples l (2, cases, LINES, pieces, SAMPLES), mm, in one axis of
    positions."""
    _, cases, _, pieces, samples = l.shape
    varied = terms_of_one(pairing, l[member].reshape(cases, -1), member)
    once = terms_of_one(pairing, l[1 - member, :, :, 0, 0], 1 - member)
    fixed = Terms(**{name: np.repeat(value, pieces * samples, axis=-1) for name, value in vars(once).items()})
    return (fixed, varied) if member else (varied, fixed)


def _solved_between(
    part: Pairing, units: FloatArray, sides: FloatArray, side: FloatArray, halvings: int
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Give points z (points, 1, 4) of curves between `sides` (2, 2, points, 1), and which are solved; the
    others are bisected only, NaN without a common normal."""
    start = _bisected(part, sides, side, halvings).T[:, None] / units
    tangent = direction_of(linearised(part, start, units)[1])
    z, solved = onto_curve(part, start, tangent, units, PASSES)
    solved &= np.linalg.norm(z - start, axis=-1) < LONGEST
    return np.where(solved[..., None], z, start), solved[:, 0]


def _bisected(part: Pairing, ends: FloatArray, gap: FloatArray, halvings: int) -> FloatArray:
    """Give points y (4, points) near the change of sign between `ends` (2, 2, points, 1), of which the first
    has the sign of `gap`; NaN where neither side has a common normal."""
    near, far = ends
    for _ in range(halvings):
        between = 0.5 * (near + far)
        same = np.signbit(guarded_gap(part, meet(part, between))) == np.signbit(gap)
        near, far = np.where(same, between, near), np.where(same, far, between)
    y = np.full((4, gap.shape[0]), np.nan)
    for l in (near, far):
        met = meet(part, l)
        y = np.where(np.isnan(y), np.array((*l, met.normal_x, met.across[0]))[..., 0], y)
        y[:, np.isnan(y).any(axis=0)] = np.nan
    return y


def _within(
    pairing: Pairing, z: FloatArray, units: FloatArray, farthest: float
) -> tuple[NDArray[np.bool_], FloatArray]:
    """Say whether points (cases, 1, 4) lie in the window, `farthest` at most, and how far along the axes of
    both members from mid-face, (cases, 2), in face widths."""
    y = np.moveaxis(z * units, -1, 0)
    height, _ = axial_and_radius(pairing, meet_on_curve(pairing, y)[1])
    faces = (height / (2.0 * pairing.half_width))[..., 0].T
    low, high = window_of(pairing)
    inside = np.all((y[:2] >= low) & (y[:2] <= high), axis=0)[:, 0] & (np.abs(faces) <= farthest).all(axis=-1)
    return np.asarray(inside), np.asarray(faces)


def _distance(z: FloatArray, line: FloatArray) -> FloatArray:
    """Give distances (points) of z (points, 4) from a line through points (corners, 4), in sides of the line
    where these are longer than LONGEST, else in LONGEST."""
    if len(line) < 2:
        return np.asarray(np.linalg.norm(z - line[0], axis=-1)) / LONGEST
    side = np.diff(line, axis=0)
    from_corner = z[:, None] - line[:-1]
    share = np.einsum("pci,ci->pc", from_corner, side) / np.einsum("ci,ci->c", side, side)
    foot = from_corner - np.clip(share, 0.0, 1.0)[..., None] * side
    size = np.maximum(np.linalg.norm(side, axis=-1), LONGEST)
    return np.asarray((np.linalg.norm(foot, axis=-1) / size).min(axis=-1))


def _traced_both_ways(
    pairing: Pairing, units: FloatArray, start: FloatArray, names: NDArray[np.int_], farthest: float
) -> list[TracedCurve]:
    """Give the curves through `start` (cases, 4), one a case; `names` are the numbers of the cases."""
    twice = np.tile(np.arange(len(names)), 2)
    pairing, units, z = pairing.cases(twice), units[twice], start[twice]
    tangent = direction_of(linearised(pairing, z[:, None], units)[1])[:, 0]
    tangent[len(names) :] *= -1.0
    lines, stops = _trace(pairing, units, z, tangent, farthest)
    curves = []
    for k, name in enumerate(names.tolist()):
        ahead, back = lines[k], lines[k + len(names)]
        closed = bool(stops[k] == Stop.CLOSED)
        points = ahead if closed else np.concatenate((back[:0:-1], ahead))
        lost = bool((stops[[k, k + len(names)]] == Stop.LOST).any())
        curves.append(TracedCurve(name, points, closed, lost))
    return curves


def _trace(
    pairing: Pairing, units: FloatArray, start: FloatArray, tangent: FloatArray, farthest: float
) -> tuple[list[FloatArray], NDArray[np.int_]]:
    """Trace from `start` (traces, 4) along `tangent`: points of each, and the codes of `Stop`."""
    z, first, (_, faces) = start.copy(), tangent, _within(pairing, start[:, None], units, farthest)
    step, faces = FIRST_STEP * _far(faces).max(axis=-1), faces.copy()
    tangent, taken = tangent.copy(), np.zeros(len(start), dtype=int)
    stops = np.full(len(start), int(Stop.LOST))
    active, steps = np.arange(len(start)), [start.copy()]
    for _ in range(MOST_STEPS):
        part, far = pairing.cases(active), _far(faces[active])
        ahead, turned, cosine, good = _one_step(part, units[active], z[active], tangent[active], step[active])
        inside, reached = _within(part, ahead[:, None], units[active], farthest)
        good &= (np.abs(reached - faces[active]) < ONWARD * far).all(axis=-1)
        moved = active[good]
        z[moved], tangent[moved], faces[moved] = ahead[good], turned[good], reached[good]
        taken[moved] += 1
        reached = np.full(z.shape, np.nan)
        reached[moved] = z[moved]
        steps.append(reached)
        most = LONGEST * _far(faces[active]).max(axis=-1)
        longer = np.where(cosine > BEND, np.minimum(1.5 * step[active], most), step[active])
        step[active] = np.where(good, np.minimum(longer, most), 0.5 * step[active])
        home = np.linalg.norm(z[active] - start[active], axis=-1) < step[active]
        home &= np.einsum("...i,...i", tangent[active], first[active]) > 0.5
        outside, closed = good & ~inside, good & home & (taken[active] > 4)
        stops[active[outside]], stops[active[closed]] = Stop.WINDOW, Stop.CLOSED
        steps[-1][active[closed]] = start[active[closed]]
        active = active[~(outside | closed | (step[active] < SHORTEST))]
        if active.size == 0:
            break
    history = np.stack(steps)
    return [history[~np.isnan(history[:, k, 0]), k] for k in range(len(start))], stops


def _far(faces: FloatArray) -> FloatArray:
    """Say how much longer than near the flanks steps may be, for each member."""
    return np.asarray(np.maximum(1.0, GROWTH * (np.abs(faces) - 1.0)))


def _one_step(
    part: Pairing, units: FloatArray, z: FloatArray, tangent: FloatArray, step: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
    """Give points and tangents a step further, cosines of the turn, and whether the steps are good.

    Of long steps, far from the faces, w1 counts less: l1, l2 and n_x tell one curve from the next."""
    predicted = (z + step[:, None] * tangent)[:, None]
    ahead, solved = onto_curve(part, predicted, tangent[:, None], units, PASSES)
    turned = direction_of(linearised(part, ahead, units)[1])[:, 0]
    weight = np.ones(z.shape)
    weight[:, 3] = np.minimum(1.0, LONGEST / step)
    before, after = weight * tangent, weight * turned
    size = np.linalg.norm(before, axis=-1) * np.linalg.norm(after, axis=-1)
    cosine = np.einsum("...i,...i", after, before) / size
    drift = np.linalg.norm(weight * (ahead - predicted)[:, 0], axis=-1)
    moved = np.linalg.norm(weight * (ahead[:, 0] - z), axis=-1)
    good = solved[:, 0] & (np.abs(cosine) > TURN) & (drift < DRIFT * moved) & (moved < 2.0 * LONGEST)
    return ahead[:, 0], np.copysign(1.0, cosine)[:, None] * turned, np.abs(cosine), good


def near_flanks(pairing: Pairing, curves: list[TracedCurve]) -> list[Part]:
    """Give the parts of curves that may lie on the flanks, with a little more at both ends."""
    if not curves:
        return []
    case = np.concatenate([np.full(len(curve.points), curve.case) for curve in curves])
    part = pairing.cases(case)
    y = np.concatenate([curve.points for curve in curves])[:, None] * units_of(part)
    y = np.moveaxis(y, -1, 0)
    height, radius = axial_and_radius(part, meet_on_curve(part, y)[1])
    margins = limit_margins(part, y[:2], height, radius)[..., 0]
    near = np.all(np.abs(height) <= (1.0 + OUTSIDE) * part.half_width, axis=0)[:, 0]
    depth, face = (part.highest - part.lowest)[..., 0], 2.0 * part.half_width[..., 0]  # as in `Limit`
    margins /= np.concatenate((depth, depth, face, face))
    parts, start = [], 0
    for curve in curves:
        here = slice(start, start + len(curve.points))
        parts += _cut(curve, near[here], margins[:, here])
        start = here.stop
    return parts


def _cut(curve: TracedCurve, near: NDArray[np.bool_], margins: FloatArray) -> list[Part]:
    """Give the parts of one curve, from which of its points are near, and their margins (8, points)."""
    points = curve.points
    if curve.closed:  # begin where it is furthest outside
        order = np.roll(np.arange(len(points) - 1), -int(margins[:, :-1].min(axis=0).argmin()))
        order = np.append(order, order[0])
        points, near, margins = points[order], near[order], margins[:, order]
        if margins.min() > 0.0:
            return [Part(curve.case, points, True)]
    edges = np.flatnonzero(np.diff(np.concatenate(([0], near, [0]))))
    parts = []
    for first, last in edges.reshape(-1, 2):
        run = slice(max(first - 2, 0), last + 2)
        if (curve.lost or len(points[run]) > 1) and (margins[:, first:last].max(axis=1) > -SPARE).all():
            parts.append(Part(curve.case, points[run], False))
    return parts
