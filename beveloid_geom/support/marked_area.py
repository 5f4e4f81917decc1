"""Area of the region of a surface in which a function is negative, with an error bound.

The function is given on a regular grid of a chart of the surface. The border of the region has a vertex where
the function changes sign between neighbouring grid points. Vertices are connected cell by cell to closed
polygons. Two kinds of errors are estimated:

1. A vertex is interpolated between the nearest values on its line. Its uncertainty is the distance to the
   zeros of straight lines through the values on either side.
2. A chord between two vertices omits at most the triangle between the directions of its neighbours, because
   an arc without an inflection point lies inside it.

The error of the area is the sum of both over the border. Where it is largest, the function is evaluated
again: near uncertain vertices, and on the normal in the middle of chords, to insert a vertex. This is
repeated until the error is within the bound.

Kinks need no special treatment: different lines fit on their two sides, which increases the uncertainty. A
strip between two lines of the grid is detected by values that decrease towards it from both sides. A grid
line is inserted there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import NamedTuple, TypeAlias

import numpy as np

from ..arrays import FloatArray, Integers, Mask

Function: TypeAlias = Callable[[FloatArray], FloatArray]
"""Function values (n,) at points (n, 2) of the unit square; inf where there are none."""


class MarkedArea(NamedTuple):
    """Area of a region (mm^2), its relative error, the total area of the surface (mm^2), and the border of
    the region: closed polygons (n, 2) in the unit square with the region on their left."""

    area: float
    error: float
    total: float
    border: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class _Border:
    """Closed polygons with the region on their left.

    Vertex k is at `base` + `t` `direction` (n, 2). The region is where t is smaller. The zero is between
    `low` and `high`, where the function has the values `below` and `above`. The uncertainty of t is `doubt`,
    and `following` (n,) is the index of the next vertex."""

    base: FloatArray
    direction: FloatArray
    t: FloatArray
    low: FloatArray
    high: FloatArray
    below: FloatArray
    above: FloatArray
    doubt: FloatArray
    following: Integers


def marked_area(function: Function, table: FloatArray, points: FloatArray, bound: float) -> MarkedArea:
    """Return the area where a function is negative on a surface, with its error and border.

    Parameters
    ----------
    function : callable
        Function values (n,) at points (n, 2) of the unit square.
    table : array (n, m)
        Function values on a regular grid of the unit square.
    points : array (n, m, 3)
        Points of the surface on this grid, mm.
    bound : float
        Requested relative error of the area.

    Returns
    -------
    MarkedArea
        The error exceeds the bound if 12 improvements are not sufficient, if an improvement makes it much
        larger, or if the border has more than 20,000 vertices. The result is the best of them.
    """
    size = np.array([_length(points), _length(np.swapaxes(points, 0, 1))])
    amount = _amount(points)
    total = float(np.trapezoid(amount[-1], dx=1.0 / (table.shape[1] - 1)))

    def placed(places: FloatArray) -> FloatArray:
        """Return the function at points (n, 2), mm, of the chart; infinite outside."""
        share = places / size
        inside = ((share >= 0.0) & (share <= 1.0)).all(axis=1)
        values = np.full(len(places), np.inf)
        values[inside] = function(share[inside])
        return values

    border = _marched(placed, *_resolved(placed, table, size, bound))
    density, least = total / size.prod(), np.inf
    # Largest number of improvements of the border.
    max_rounds = 12
    for count in range(max_rounds + 1):
        places = _vertices(border, size)
        area = _area_inside(places / size, border.following, amount)
        spread, cut = density * _spread(border, places), density * _cut_off(border, places, size)
        error, allowed = float(spread.sum() + cut.sum()), bound * max(area, 0.0)
        if error < least:
            least, best = error, (area, places / size, border.following)
        diverges = error > 4.0 * least  # the border is not a line at this scale
        if error <= allowed or diverges or count == max_rounds or len(places) > 20_000:
            break
        moved, split = _worst(spread, allowed / 4.0), _worst(cut, allowed / 4.0)
        border = _improved(placed, border, places, moved, split[_settled(border, places)[split]])
    area, share, following = best
    return MarkedArea(area, least / area if least > 0.0 else 0.0, total, _polygons(share, following))


def _polygons(vertices: FloatArray, following: Integers) -> tuple[FloatArray, ...]:
    """Return the closed polygons (n, 2) of vertices (m, 2), each of which has a following one."""
    polygons, remaining = [], set(range(len(vertices)))
    while remaining:
        ring, vertex = [], min(remaining)
        while vertex in remaining:
            remaining.remove(vertex)
            ring.append(vertex)
            vertex = int(following[vertex])
        polygons.append(vertices[ring])
    return tuple(polygons)


def _length(points: FloatArray) -> float:
    """Return the mean length (mm) of the lines of a grid along its first axis."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=-1).sum(axis=0).mean())


def _amount(points: FloatArray) -> FloatArray:
    """Return the integral of the area density over the first coordinate, up to each point, mm^2.

    The area of a region of the unit square is the integral of this quantity over the second coordinate along
    its border."""
    steps = [1.0 / (n - 1) for n in points.shape[:2]]
    along = [np.gradient(points, step, axis=axis, edge_order=2) for axis, step in enumerate(steps)]
    density = np.linalg.norm(np.cross(along[0], along[1]), axis=-1)
    strips = 0.5 * steps[0] * (density[1:] + density[:-1])
    return np.concatenate((np.zeros((1, points.shape[1])), np.cumsum(strips, axis=0)))


def _area_inside(share: FloatArray, following: Integers, amount: FloatArray) -> float:
    """Return the area (mm^2) inside polygons with vertices (n, 2) in the unit square."""
    last = np.array(amount.shape) - 1
    place = share * last
    corner = np.minimum(place.astype(int), last - 1)
    (i, j), (x, y) = corner.T, (place - corner).T
    low, high = ((1.0 - x) * amount[i, k] + x * amount[i + 1, k] for k in (j, j + 1))
    value = (1.0 - y) * low + y * high
    return float(0.5 * (value + value[following]) @ (share[following, 1] - share[:, 1]))


def _resolved(
    function: Function, table: FloatArray, size: FloatArray, bound: float
) -> tuple[FloatArray, list[FloatArray]]:
    """Return the table and its grid lines (n,), (m,), mm, with more lines where strips would be missed."""
    lines = [np.linspace(0.0, length, count) for length, count in zip(size, table.shape, strict=True)]
    for _ in range(8):
        before = table.shape
        for axis in (0, 1):
            rows, line = np.moveaxis(table, axis, 0), lines[axis]
            hidden = np.maximum(_hidden(rows, line), _hidden(-rows, line))
            wide, high = np.gradient(lines[1 - axis]), np.gradient(line)
            if hidden.sum(axis=0) @ wide <= 0.25 * bound * (high @ (rows <= 0.0) @ wide):
                continue
            after = np.flatnonzero(hidden.any(axis=1))
            lines[axis] = np.insert(line, after + 1, 0.5 * (line[after] + line[after + 1]))
            added = 0.5 * (rows[after] + rows[after + 1])
            needed = (hidden[after] > 0.0) | ((rows[after] <= 0.0) != (rows[after + 1] <= 0.0))
            row, column = np.nonzero(needed)
            places = lines[axis][(after + 1 + np.arange(after.size))[row]], lines[1 - axis][column]
            added[row, column] = function(np.stack(places if axis == 0 else places[::-1], axis=-1))
            table = np.moveaxis(np.insert(rows, after + 1, added, axis=0), 0, axis)
        if table.shape == before:
            break
    return table, lines


def _hidden(rows: FloatArray, line: FloatArray) -> FloatArray:
    """Return widths (n - 1, m), mm, of strips between lines (n,) in which the function may be negative,
    although its values on both lines are positive; 0 where there is none.

    From both lines, the values are extrapolated into the interval between them, with twice the slope of the
    neighbouring interval. The strip lies between the zeros of both extrapolations."""
    step = np.diff(line)[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        fall = -np.diff(rows, axis=0) / step
        none = np.full((1, rows.shape[1]), np.nan)
        before, after = np.concatenate((none, fall[:-1])), -np.concatenate((fall[1:], none))
        before, after = (
            2.0 * np.maximum(np.where(np.isfinite(one), one, other), 0.0)
            for one, other in ((before, after), (after, before))
        )
        width = step - rows[:-1] / before - rows[1:] / after
    return np.where((rows[:-1] > 0.0) & (rows[1:] > 0.0) & (width > 0.0), width, 0.0)


def _marched(function: Function, table: FloatArray, lines: list[FloatArray]) -> _Border:
    """Return the border of the negative values of a table, cell by cell (marching squares).

    A rim of no width around the chart does not belong to the region, so that the border is closed."""
    f = np.pad(table, 2, constant_values=np.inf)
    node = np.arange(f.size).reshape(f.shape)
    corners = np.stack((node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]), axis=-1).reshape(-1, 4)
    inside = f.ravel()[corners] <= 0.0
    mixed = inside.any(axis=1) & ~inside.all(axis=1)
    corners, inside = corners[mixed], inside[mixed]
    next_inside = np.roll(inside, -1, axis=1)
    leaves, enters = inside & ~next_inside, ~inside & next_inside
    cell, side = np.nonzero(leaves)
    others = (side[:, None] + (1, 2, 3)) % 4
    first = enters[cell[:, None], others].argmax(axis=1)
    rows, columns = (np.pad(line, 2, mode="edge") for line in lines)
    place = np.stack(np.meshgrid(rows, columns, indexing="ij"), axis=-1).reshape(-1, 2)
    # Two opposite corners inside are separate, or connected if the function is negative in the middle.
    apart = leaves.sum(axis=1) == 2
    if apart.any():
        apart[apart] = function(place[corners[apart]].mean(axis=1)) > 0.0
    back = others[np.arange(len(cell)), np.where(apart[cell], 2, first)]
    start = corners[cell, side] * f.size + corners[cell, (side + 1) % 4]
    end = corners[cell, (back + 1) % 4] * f.size + corners[cell, back]
    order = np.argsort(start)
    first_node, neighbour = np.divmod(start[order], f.size)
    base, direction = place[first_node], place[neighbour] - place[first_node]
    line = np.stack([first_node + k * (neighbour - first_node) for k in (-1, 0, 1, 2)], axis=-1)
    fixed = (direction == 0.0).all(axis=1)
    length = np.where(fixed, 1.0, (direction**2).sum(axis=1))
    t = ((place[line] - base[:, None]) * direction[:, None]).sum(axis=-1) / length[:, None]
    crossings = np.where(fixed, 0.0, _crossing(t, f.ravel()[line], np.full(len(first_node), 0.5)))
    t, low, high, below, above, doubt = crossings
    following = np.searchsorted(start[order], end[order])
    return _Border(base, direction, t, low, high, below, above, doubt, following)


def _crossing(t: FloatArray, f: FloatArray, near: FloatArray) -> FloatArray:
    """Return `t`, `low`, `high`, `below`, `above` and `doubt` (6, n) of `_Border` for the zero nearest to
    `near`.

    `f` (n, k) are values at increasing `t` (n, k). If all values belong to the region, the last t is
    returned, and if none does, the first one."""
    n, k = t.shape
    leaves = (f[:, :-1] <= 0.0) & (f[:, 1:] > 0.0)
    away = np.where(leaves, np.abs(0.5 * (t[:, :-1] + t[:, 1:]) - near[:, None]), np.inf)
    pick, row = away.argmin(axis=1), np.arange(n)
    low, high, below, above = t[row, pick], t[row, pick + 1], f[row, pick], f[row, pick + 1]
    span = high - low
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        place = np.where(np.isfinite(above), low + span * below / (below - above), 0.5 * (low + high))
        slope = np.diff(f, axis=1) / np.diff(t, axis=1)
        slope = np.where(np.isfinite(slope), slope, np.nan)
        left = np.where(pick > 0, slope[row, pick - 1], np.nan)
        right = np.where(pick < k - 2, slope[row, np.minimum(pick + 1, k - 2)], np.nan)
        left = np.where(left > 0.0, low - below / left, np.where(left <= 0.0, high, np.nan))
        right = np.where(right > 0.0, high - above / right, np.where(right <= 0.0, low, np.nan))
        apart = np.abs(np.clip([left, right], low, high) - place)
    known = np.isfinite(apart)
    doubt = np.where(known.any(axis=0), np.where(known, apart, 0.0).max(axis=0), 0.25 * span)
    doubt = np.where(np.isfinite(above), doubt, 0.5 * span)
    end = np.where((f <= 0.0).all(axis=1), t[:, -1], t[:, 0])
    nowhere = (end, end, end, *np.zeros((3, n)))
    return np.where(leaves.any(axis=1), (place, low, high, below, above, doubt), nowhere)


def _vertices(border: _Border, size: FloatArray) -> FloatArray:
    """Return the vertices (n, 2), mm, limited to the chart."""
    return np.clip(border.base + border.t[:, None] * border.direction, 0.0, size)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _spread(border: _Border, places: FloatArray) -> FloatArray:
    """Return the area (n,) by which the uncertainty of each vertex can change the region."""
    before = places[np.argsort(border.following)]
    return 0.5 * border.doubt * np.abs(_cross(border.direction, places[border.following] - before))


def _cut_off(border: _Border, places: FloatArray, size: FloatArray) -> FloatArray:
    """Return the area (n,) that the chord after each vertex can omit.

    It is the area of the triangle on the chord with the mean of the direction changes at its ends. Changes at
    the edges of the chart are not used, and a chord along an edge is exact."""
    chord = places[border.following] - places
    last = chord[np.argsort(border.following)]
    turn = np.abs(np.arctan2(_cross(last, chord), (last * chord).sum(axis=1)))
    edge = (places <= 0.0) | (places >= size)
    turn = np.where(edge.any(axis=1), np.nan, turn)
    ends = np.stack((turn, turn[border.following]))
    known = np.isfinite(ends)
    mean = np.where(known, ends, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    angle = np.where(known.any(axis=0), mean, 0.5)  # rad, of a chord between two edges of the chart
    along = (edge & edge[border.following] & (chord == 0.0)).any(axis=1)
    triangle = 0.25 * (chord**2).sum(axis=1) * np.tan(np.minimum(angle, 1.4))
    return np.where(along, 0.0, triangle)


def _worst(errors: FloatArray, allowed: float) -> Integers:
    """Return the indices of the largest errors, without which the sum of the others is allowed."""
    order = np.argsort(errors)
    return order[np.cumsum(errors[order]) > allowed]


def _settled(border: _Border, places: FloatArray) -> Mask:
    """Return whether the ends of the chord after each vertex are uncertain by less than a quarter of it."""
    doubt = border.doubt * np.hypot(*border.direction.T)
    return np.asarray(
        4.0 * (doubt + doubt[border.following]) < np.hypot(*(places[border.following] - places).T)
    )


def _improved(
    function: Function,
    border: _Border,
    places: FloatArray,
    moved: Integers,
    split: Integers,
) -> _Border:
    """Return the border with vertices `moved` searched again and new ones in the middle of chords `split`."""
    following, added = border.following.copy(), len(places) + np.arange(len(split))
    end = following[split]
    following = np.append(following, end)
    following[split] = added
    chord = places[end] - places[split]
    base = np.concatenate((border.base, 0.5 * (places[split] + places[end])))
    direction = np.concatenate((border.direction, chord[:, ::-1] * (1.0, -1.0)))
    rows = np.stack([getattr(border, field.name) for field in fields(border)[2:8]])
    rows = np.hstack((rows, np.zeros((6, len(split)))))
    t, low, high, below, above, doubt = rows[:, moved, None]
    first, last = np.maximum(t - doubt, low), np.minimum(t + doubt, high)
    # Positions at which a vertex is searched again, in shares of its uncertainty interval.
    vertex_samples = (np.arange(8) + 0.5) / 8.0
    again = first + (last - first) * vertex_samples
    # Positions at which a vertex is searched on the normal of a chord, in lengths of the chord.
    normal_samples = np.array([-2.0, -0.5, -0.125, -0.03, 0.0, 0.03, 0.125, 0.5, 2.0])
    across = np.broadcast_to(normal_samples, (len(split), normal_samples.size))
    rays = ((moved, again), (added, across))
    asked = [(base[k, None] + t[..., None] * direction[k, None]).reshape(-1, 2) for k, t in rays]
    values = function(np.concatenate(asked))
    f = np.concatenate((below, values[: again.size].reshape(again.shape), above), axis=1)
    rows[:, moved] = _crossing(np.concatenate((low, again, high), axis=1), f, t[:, 0])
    rows[:, added] = _crossing(across, values[again.size :].reshape(across.shape), np.zeros(len(split)))
    t, low, high, below, above, doubt = rows
    return _Border(base, direction, t, low, high, below, above, doubt, following)
