"""The smooth pieces of which the curve of first contact over a mesh cycle consists.

A piece is carried in one way: by one tooth pair, in a tangency, on an edge of one member or on the edges
of two limits, on flank or fillet. With its limits held to, a contact is the root of two equations in
(s1, z1), smooth in the pinion's roll and beyond the piece's own ends:

    no limit     grad f = 0
    one limit    c = 0, t.grad f = 0 with t along c = 0
    two limits   c1 = c2 = 0

(`least_clearance` has f and the limits c). First contacts at some rolls tell the carriers; Newton's method
gives the contacts of each at Chebyshev points of the roll, and the polynomials through them say where
one carrier takes over from the next: where f is less, or where a contact comes within the limits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..status import Limit
from ..support.chebyshev import basis_of, evaluate, greatest, polynomials
from .first_contact import TOGETHER, Found, Mesh
from .least_clearance import Local, Task, local_at, square

SAMPLES = 24
"""Rolls of a pitch at which first contacts tell the carriers."""
DEGREE, PASSES, LAST_STEP, EXACT = 20, 12, 1e-7, 1e-12
"""Degree of the polynomials; Newton steps at most; share of the tooth depth below which one is the last, and
below which it is not made."""
FITS, SETTLED = 12, 1e-12
"""How often the polynomials are fitted while their ends move by more than this share of a pitch."""
TAIL, NOISE = 4, np.array((1e-15, 1e-11, 1e-11, 1e-11, 1e-11))
"""Last coefficients, and sizes of f, over the lever, and of places, over the tooth depth, at which they are
rounding: polynomials with such a tail are right on every part of their range."""
KNOWN = 1e-6
"""Share of the tooth depth below which a tail says that a former fit tells where to start the next."""
AROUND = 1e-3
"""Share of its length by which a piece may end beyond the range it was fitted on."""
PARTS = 128, *[32] * 7
"""Into how many parts the interval of an end is divided, one time after the other."""
SHORT = 1e-9
"""Pitches below which a piece is part of the change: rounding may change the carrier to and fro."""
BEYOND = 1.2
"""Half lengths from its middle up to which a piece's polynomials are asked."""
QUANTITIES = 5
"""Rows of a piece's polynomials: f, s1, z1, s2, z2, mm."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces (n,) of the cases `case`, in order of case and roll, from `low` to `high`, rad of the pinion's
    roll; `coefficients` (5, n, DEGREE + 1) of Chebyshev polynomials of f, s1, z1, s2, z2, mm; the tooth
    `pair`, `limit` (2, n) and `on_fillet` (2, n) as in `FirstContact`."""

    case: Integers
    low: FloatArray
    high: FloatArray
    coefficients: FloatArray
    pair: Integers
    limit: Codes
    on_fillet: Mask

    def pick(self, index: Integers | Mask) -> Pieces:
        """Give the pieces `index`."""
        rows = (x[:, index] if x.ndim > 1 else x[index] for x in vars(self).values())
        return Pieces(*rows)

    def number(self, mesh: Mesh, case: Integers, roll: FloatArray) -> Integers:
        """Say which piece holds the rolls (n,), rad, of the cases (n,) of a mesh, over its span."""
        begins = order_of(mesh, self.case, self.low)
        return np.maximum(np.searchsorted(begins, order_of(mesh, case, roll), side="right") - 1, 0)

    def rolls(self, places: FloatArray) -> FloatArray:
        """Give rolls (n, k), rad, at `places` (k,) from -1, where the pieces begin, to 1, where they end."""
        return _rolls(self.low, self.high, places)

    def values(self, index: Integers, roll: FloatArray) -> FloatArray:
        """Give all quantities (rows, n, k) of the pieces `index` (n,) at rolls (n, k), rad."""
        low, high = self.low[index, None], self.high[index, None]
        with np.errstate(invalid="ignore", divide="ignore"):
            place = (2.0 * roll - (low + high)) / (high - low)
        place = np.where(np.isnan(place), 0.0, np.minimum(np.maximum(place, -BEYOND), BEYOND))
        return evaluate(self.coefficients[:, index], place)

    def values_at(self, index: Integers, roll: FloatArray, rows: int | None = None) -> FloatArray:
        """Give the first `rows` quantities (rows, n), or all, of the pieces `index` (n,) at rolls (n,),
        rad."""
        low, high = self.low[index], self.high[index]
        place = np.minimum(np.maximum((2.0 * roll - (low + high)) / (high - low), -BEYOND), BEYOND)
        powers = polynomials(place, DEGREE)
        return np.array([(row.T[:, index] * powers).sum(axis=0) for row in self.coefficients[:rows]])


@dataclass(frozen=True, eq=False)
class Samples:
    """First contacts (n,) of the cases at rolls, in their order; `cut`: a piece begins here in any case."""

    case: Integers
    roll: FloatArray
    cut: Mask
    found: Found

    def pick(self, index: Integers | Mask) -> Samples:
        """Give the samples `index`."""
        return Samples(self.case[index], self.roll[index], self.cut[index], self.found.pick(index))

    def ends(self, case: Integers) -> tuple[FloatArray, FloatArray]:
        """Give the first and the last rolls (n,), rad, of the cases (n,)."""
        first, after = np.searchsorted(self.case, case), np.searchsorted(self.case, case, side="right")
        return self.roll[first], self.roll[after - 1]

    def and_also(self, other: Samples) -> Samples:
        """Give both, in order of case and roll."""
        rows = zip(vars(self.found).values(), vars(other.found).values(), strict=True)
        both = Samples(
            np.append(self.case, other.case),
            np.append(self.roll, other.roll),
            np.append(self.cut, other.cut),
            Found(*(np.concatenate(row, axis=-1) for row in rows)),
        )
        return both.pick(np.lexsort((both.roll, both.case)))


def samples_of(case: Integers, roll: FloatArray, found: Found) -> Samples:
    """Give first contacts (n,) of the cases at rolls, none of which cuts a piece."""
    return Samples(case, roll, np.zeros(case.size, dtype=bool), found)


def holding(limit: Codes) -> Mask:
    """Say which of the limits (8, n) hold contacts of limits (2, n)."""
    return np.asarray((np.arange(len(Limit))[:, None, None] == limit).any(axis=1))


def fitted(mesh: Mesh, samples: Samples) -> Pieces:
    """Give pieces with the carriers of the samples of each case, ending where the next one takes over."""
    pieces, runs, limits = _runs_of(mesh, samples)
    number, done, former = np.arange(pieces.case.size), [], None
    ends = limits[0]
    for count in range(FITS):
        starts = _starts(mesh, samples, pieces, runs, former)
        whole = replace(pieces, coefficients=_coefficients(mesh, pieces, starts))
        joined = np.flatnonzero(pieces.case[1:] == pieces.case[:-1])
        found = _ends(mesh, whole, joined, limits[:, joined])
        low, high = pieces.low.copy(), pieces.high.copy()
        low[joined + 1], high[joined] = found, found
        pieces = replace(whole, low=low, high=high)
        steady = np.ones(pieces.case.size, dtype=bool)
        steady[joined] = np.abs(found - ends[joined]) <= SETTLED * mesh.pitch[0]
        slack = AROUND * (whole.high - whole.low)  # further beyond a fit its noise grows
        known = (low >= whole.low - slack) & (high <= whole.high + slack) & _resolved(mesh, whole)
        steady, known = (_of_whole_cases(mask, pieces.case) for mask in (steady, known))
        ready = steady | known | (count == FITS - 1)
        moved = np.flatnonzero(ready & ~steady)  # polynomials of what lies between the new ends
        values = whole.values(moved, pieces.pick(moved).rolls(basis_of(DEGREE).nodes))
        pieces.coefficients[:, moved] = basis_of(DEGREE).coefficients(values)
        ended, on = np.flatnonzero(ready), np.flatnonzero(~ready)
        done.append((number[ended], pieces.pick(ended)))
        if not on.size:
            break
        ends, length = high, high - low
        reach = 0.5 * (BEYOND - 1.0) * np.minimum(length[:-1], length[1:])
        limits[0, :-1] = np.maximum(limits[0, :-1], ends[:-1] - reach)
        limits[1, :-1] = np.minimum(limits[1, :-1], ends[:-1] + reach)
        number, pieces, former = number[on], pieces.pick(on), whole.pick(on)
        runs, limits, ends = runs[:, on], limits[:, on], ends[on]
    order = np.concatenate([numbers for numbers, _ in done]).argsort()
    return _without_short(mesh, put_together([part for _, part in done]).pick(order), samples)


def _runs_of(mesh: Mesh, samples: Samples) -> tuple[Pieces, Integers, FloatArray]:
    """Give pieces without coefficients, as far as their carriers may reach; the first and the last of the
    samples of each (2, n); and between which rolls (2, n), rad, the next of the same case may take over."""
    found, case = samples.found, samples.case
    on_fillet = np.stack((found.place[0] < mesh.own.joint, found.meeting[0] < mesh.other.joint))
    label = np.array((case, found.pair, *found.limit, *on_fillet))
    begins = np.append(True, (label[:, 1:] != label[:, :-1]).any(axis=0) | samples.cut[1:])
    first = np.flatnonzero(begins)
    last = np.append(first[1:], case.size) - 1
    joined = np.flatnonzero(case[first[1:]] == case[last[:-1]])
    low, high = samples.roll[first], samples.roll[last]
    same = (label[:, first[joined]] == label[:, first[joined + 1]]).all(axis=0)  # cut
    limits = np.stack((high, high))
    limits[0, joined] = samples.roll[np.where(same, first[joined + 1], last[joined])]
    limits[1, joined] = samples.roll[first[joined + 1]]
    low[joined + 1], high[joined] = limits[:, joined]
    coefficients = np.empty((0, first.size, 0))
    rows = found.pair[first], found.limit[:, first], on_fillet[:, first]
    return Pieces(case[first], low, high, coefficients, *rows), np.stack((first, last)), limits


def _of_whole_cases(mask: Mask, case: Integers) -> Mask:
    """Say of pieces whether all pieces of their case are marked."""
    return np.asarray(~np.isin(case, case[~mask]))


def put_together(parts: list[Pieces]) -> Pieces:
    """Give all pieces of the parts, one after the other."""
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    return Pieces(*(np.concatenate(column, axis=min(1, column[0].ndim - 1)) for column in columns))


def _resolved(mesh: Mesh, pieces: Pieces) -> Mask:
    """Say of which pieces all polynomials are known to rounding on the whole of their range: none crosses a
    joint of flank and fillet, where contacts are not smooth, and the last coefficients are rounding."""
    depth = mesh.own.tip - mesh.own.root
    s = evaluate(pieces.coefficients[[1, 3]], np.linspace(-1.0, 1.0, DEGREE + 1))
    below = s < np.array((mesh.own.joint, mesh.other.joint))[:, None, None]
    smooth = (below == pieces.on_fillet[..., None]).all(axis=(0, 2))
    most = NOISE * np.array((mesh.lever, *[depth] * (QUANTITIES - 1)))
    return np.asarray(smooth & (tails_of(pieces) <= most[:, None]).all(axis=0))


def tails_of(pieces: Pieces) -> FloatArray:
    """Give sizes (QUANTITIES, n) of the last coefficients."""
    return np.asarray(np.abs(pieces.coefficients[:QUANTITIES, :, -TAIL:]).max(axis=2))


def _without_short(mesh: Mesh, pieces: Pieces, samples: Samples) -> Pieces:
    """Give the pieces longer than SHORT, each from where the one before ends, over the samples of each
    case."""
    long = pieces.high - pieces.low > SHORT * mesh.pitch[0]
    pieces = replace(pieces.pick(long), coefficients=pieces.coefficients[:QUANTITIES, long])
    same = pieces.case[1:] == pieces.case[:-1]
    low, high = pieces.low.copy(), pieces.high.copy()
    start, stop = samples.ends(pieces.case)
    low[1:] = np.where(same, high[:-1], start[1:])
    low[:1] = start[:1]
    ends = np.append(~same, True)
    high[ends] = stop[ends]
    return replace(pieces, low=low, high=high)


def _starts(
    mesh: Mesh, samples: Samples, pieces: Pieces, runs: Integers, former: Pieces | None
) -> FloatArray:
    """Give places (2, n * (DEGREE + 1)) near the contacts at the nodes of the pieces, whose samples are those
    from the first to the last of the `runs` (2, n): by a `former` fit where it is known, elsewhere on
    straight lines between samples, which far from any of them may lead Newton's method astray."""
    roll = pieces.rolls(basis_of(DEGREE).nodes)
    order = order_of(mesh, samples.case, samples.roll)
    after = np.searchsorted(order, order_of(mesh, pieces.case.repeat(roll.shape[1]), roll.ravel()))
    first, last = (run.repeat(roll.shape[1]) for run in runs)
    before = np.maximum(np.minimum(after, last) - 1, first)
    after = np.minimum(before + 1, last)
    step = samples.roll[after] - samples.roll[before]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        share = np.clip(np.where(step > 0.0, (roll.ravel() - samples.roll[before]) / step, 0.0), -1.0, 2.0)
    place = samples.found.place[:, before]
    place = place + share * (samples.found.place[:, after] - place)
    if former is None:
        return np.asarray(place)
    known = (tails_of(former)[1:3] <= KNOWN * (mesh.own.tip - mesh.own.root)).all(axis=0)
    fit = former.values(np.arange(known.size), roll)[1:3]
    return np.where(known.repeat(roll.shape[1]), fit.reshape(2, -1), place)


def _coefficients(mesh: Mesh, pieces: Pieces, starts: FloatArray) -> FloatArray:
    """Give coefficients (13, n, DEGREE + 1) of f, places and the eight limits of the pieces, found from
    places near their nodes; NaN where a contact is not found."""
    basis = basis_of(DEGREE)
    roll = pieces.rolls(basis.nodes)
    case = pieces.case.repeat(roll.shape[1])
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        here = mesh.at(case, roll.ravel())
        task = here.task(np.arange(case.size), pieces.pair.repeat(roll.shape[1]))
        values = held_to(task, starts, pieces.limit.repeat(roll.shape[1], axis=1))
        return basis.coefficients(values.reshape(-1, *roll.shape))


def _rolls(low: FloatArray, high: FloatArray, nodes: FloatArray) -> FloatArray:
    """Give rolls (n, k) at places -1 ... 1 of intervals (n,)."""
    return np.asarray(0.5 * ((low + high)[:, None] + (high - low)[:, None] * nodes))


def order_of(mesh: Mesh, case: Integers, roll: FloatArray) -> FloatArray:
    """Give numbers that rise with case and roll, over the span of a mesh."""
    turned = (roll - mesh.roll[case]) / (mesh.span * mesh.pitch[0])
    return np.asarray(case + 0.5 * np.clip(turned, 0.0, 1.0))


def held_to(task: Task, place: FloatArray, limit: Codes, most: int = PASSES) -> FloatArray:
    """Give the contacts near places (2, n) that are held to the limits (2, n): f, places and the margins of
    the eight limits (13, n), mm; NaN where Newton's method does not settle within so many steps at `most`."""
    found = np.full((QUANTITIES + len(Limit), limit.shape[1]), np.nan)
    going, last = np.arange(limit.shape[1]), np.zeros(limit.shape[1], dtype=bool)
    for _ in range(most + 1):
        here = local_at(task, *place)
        step = _newton_step(here, limit)
        size = np.abs(step).max(axis=0) / task.depth
        there = last | (size <= EXACT)
        rows = here.f[None, there], place[:, there], here.meeting[:, there], here.margin[:, there]
        found[:, going[there]] = np.concatenate(rows)
        stays = np.flatnonzero(~there & np.isfinite(size))
        if not stays.size:
            break
        place, limit, last = place[:, stays] + step[:, stays], limit[:, stays], size[stays] <= LAST_STEP
        going, task = going[stays], task.pick(stays)
    return found


def _newton_step(here: Local, limit: Codes) -> FloatArray:
    """Give steps (2, n) towards the contact that is held to the limits (2, n)."""
    each = np.arange(limit.shape[1])
    rates, margins = ([row[code, ..., each] for code in limit] for row in (here.rate, here.margin))
    first, second = (rate.T for rate in rates)
    curve = square(here.curve[limit[0], :, each].T)
    size = (first * first).sum(axis=0)
    bend = square(here.bend) - np.where(limit[0] >= 0, (here.slope * first).sum(axis=0) / size, 0.0) * curve
    free = -_solved(bend[0], bend[1], here.slope)
    onto, along = -margins[0] / size * first, np.array((-first[1], first[0]))
    pull = here.slope + (bend * onto).sum(axis=1)
    on_edge = onto - (along * pull).sum(axis=0) / (along * (bend * along).sum(axis=1)).sum(axis=0) * along
    corner = -_solved(first, second, np.array(margins))
    return np.asarray(np.where(limit[1] >= 0, corner, np.where(limit[0] >= 0, on_edge, free)))


def _solved(first: FloatArray, second: FloatArray, right: FloatArray) -> FloatArray:
    """Give solutions (2, n) of two equations whose rows are (2, n) each."""
    rows = right[0] * second[1] - right[1] * first[1], first[0] * right[1] - second[0] * right[0]
    return np.asarray(np.array(rows) / (first[0] * second[1] - first[1] * second[0]))


def _ends(mesh: Mesh, pieces: Pieces, before: Integers, limits: FloatArray) -> FloatArray:
    """Give the rolls (k,) between the `limits` (2, k) at which the pieces `before` (k,) end and the next take
    over."""
    low, high = limits
    row = np.arange(before.size)
    for parts in PARTS if before.size else ():
        roll = _rolls(low, high, 2.0 * np.arange(parts + 1) / parts - 1.0)
        taken = _taken_over(mesh, pieces, before, roll)
        taken[:, -1] = True
        part = np.maximum(taken.argmax(axis=1), 1)
        low, high = (
            np.where(taken[:, 0], low, roll[row, part - 1]),
            np.where(taken[:, 0], low, roll[row, part]),
        )
    return np.asarray(high)


def _taken_over(mesh: Mesh, pieces: Pieces, before: Integers, roll: FloatArray) -> Mask:
    """Say whether at rolls (k, m) the pieces after those `before` (k,) carry: within the limits and first, of
    such as touch together a tangency before an edge, then the pair that came into mesh last."""
    both, shape = np.append(before, before + 1), (2, *roll.shape)
    values = pieces.values(both, np.concatenate((roll, roll)))
    f, outside = values[0].reshape(shape), _outside(mesh, pieces, both, values).reshape(shape)
    edge, pair = (row[both].reshape(2, -1) for row in (pieces.limit[0] >= 0, mesh.own.sigma * pieces.pair))
    together = np.abs(f[1] - f[0]) <= TOGETHER * mesh.lever
    prior = np.where(edge[0] == edge[1], pair[1] < pair[0], edge[0])[:, None]
    sooner = np.where(together, prior, f[1] < f[0])
    return np.asarray(np.where(outside[0] == outside[1], sooner, outside[1] < outside[0]))


def _outside(mesh: Mesh, pieces: Pieces, index: Integers, values: FloatArray) -> FloatArray:
    """Say how far (mm) contacts lie outside limits that do not hold them, or beyond a joint with the fillet;
    infinite where there are none."""
    margin = np.where(holding(pieces.limit[:, index])[..., None], np.inf, values[QUANTITIES:]).min(axis=0)
    for s, fillet, joint in zip(
        values[[1, 3]], pieces.on_fillet[:, index], (mesh.own.joint, mesh.other.joint), strict=True
    ):
        margin = np.minimum(margin, np.where(fillet, -1.0, 1.0)[:, None] * (s - joint))
    return np.where(np.isnan(margin), np.inf, np.maximum(-margin, 0.0))


def extremes(series: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the greatest and least value (pieces) of Chebyshev series (1, pieces, DEGREE + 1) on [-1, 1]."""
    both = np.concatenate((series, -series), axis=1)
    end = np.ones((both.shape[1], 1))
    most, least = evaluate(both, greatest(both[0], -end, end))[0, :, 0].reshape(2, -1)
    return most, -least


def changes_of(pieces: Pieces, cases: int) -> tuple[FloatArray, Mask]:
    """Give changes (cases, most) and whether the tooth pair changes there."""
    label = np.stack((pieces.pair, *pieces.limit, *pieces.on_fillet))
    changed = (label[:, 1:] != label[:, :-1]).any(axis=0)
    inner = np.flatnonzero((pieces.case[1:] == pieces.case[:-1]) & changed)
    case = pieces.case[inner]
    count = np.bincount(case, minlength=cases)
    column = np.arange(inner.size) - (np.cumsum(count) - count)[case]
    most = int(count.max(initial=0))
    changes, hand_over = np.full((cases, most), np.nan), np.zeros((cases, most), dtype=bool)
    changes[case, column] = pieces.high[inner]
    hand_over[case, column] = pieces.pair[inner] != pieces.pair[inner + 1]
    return changes, hand_over
