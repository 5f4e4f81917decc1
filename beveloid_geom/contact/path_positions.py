"""Rows of a path of contact at positions: evenly spaced from enter to leave, or at given l1.

For many positions the path is expanded in roll and evaluated; for fewer, its series is evaluated directly.
Given l1 outside the window of the series are solved one by one. A few given l1 are solved without the path
if each has exactly one contact.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..arrays import Codes, FloatArray, Mask
from ..status import Status
from ..support.chebyshev import basis_of, evaluate, inverted, real_roots, resolved_degree, with_derivative
from ..support.frozen_arrays import cached
from .ends import HALLEY_MAX_STEPS, LAST_HALLEY_STEP, Ends, halley_step, no_ends
from .equation import edge_margins, gap_tolerance
from .flank_pair import FlankPair
from .parallel.small_angle_paths import NEARLY_PARALLEL_SINE
from .path_polynomial import PHASE, ROLL, ROW_COUNT, PathSeries, exact_rows, rounding_scale
from .path_search import Group
from .roots import sole_roots


def rows_of_groups(
    groups: list[Group], points: int, given: FloatArray | None, cases: int
) -> tuple[FloatArray, Codes]:
    """Return rows (ROW_COUNT, cases, positions) and status of all cases at evenly spaced positions, or at the
    `given` l1 (cases, positions), mm.
    """
    parts = [
        _rows_on_path(group, points) if given is None else _rows_at_given(group, given[group.cases])
        for group in groups
    ]
    if len(parts) == 1:
        return parts[0]
    count = parts[0][1].shape[-1]
    table, status = np.empty((ROW_COUNT, cases, count)), np.empty((cases, count), np.int8)
    for group, (rows, codes) in zip(groups, parts, strict=True):
        table[:, group.cases], status[group.cases] = rows, codes
    return table, status


def ends_of_groups(groups: list[Group], cases: int) -> Ends:
    """Return the ends of the paths of all cases."""
    if len(groups) == 1:
        return groups[0].ends
    ends = no_ends(np.empty(cases, dtype=np.int8))
    for group in groups:
        ends.put(group.cases, group.ends)
    return ends


@cached(4)
def _shares(points: int) -> FloatArray:
    """Return evenly spaced relative positions in [-1, 1], followed by the middle 0."""
    return np.append(np.linspace(-1.0, 1.0, points), 0.0)


def _rows_on_path(group: Group, points: int) -> tuple[FloatArray, Codes]:
    """Return rows and status at positions evenly spaced from enter to leave."""
    share, series, ends = _shares(points), group.series, group.ends
    # Number of positions from which the expansion in roll is used.
    if points < 256:
        values = evaluate(series.coefficients[:ROW_COUNT], at_shares(series, ends, share))
        values, middle = values[..., :-1], values[PHASE, :, -1:].copy()
    else:
        values, middle = _by_roll(group, share[:-1])
    values[PHASE] -= middle
    return values, np.broadcast_to(ends.status[:, None], values.shape[1:])


def _by_roll(group: Group, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return rows at relative positions `share` from polynomials of the roll, if these resolve the path, else
    from the series; and PHASE (cases, 1) in the middle of the path, rad.
    """
    series, ends, rows = group.series, group.ends, group.series.coefficients[:ROW_COUNT]
    # Evaluate at Chebyshev points of the roll and fit again.
    basis = basis_of(40)
    values = evaluate(rows, at_shares(series, ends, basis.nodes))
    middle, by_roll = values[PHASE, :, basis.nodes.size // 2, None], basis.coefficients(values)
    solved = ends.status == Status.SOLVED
    degree = resolved_degree(by_roll[:, solved], rounding_scale(group.pairing)[:ROW_COUNT, solved])
    if degree is None:
        return _by_blocks(rows, at_shares(series, ends, share)), middle
    return _by_blocks(by_roll[..., : degree + 1], share), middle


def _rows_at_given(group: Group, l1: FloatArray) -> tuple[FloatArray, Codes]:
    """Return rows and status at given l1: from the series, and outside its window solved one by one."""
    pairing, series, ends = group.pairing, group.series, group.ends
    x, several = parameters_at_l1(series, ends, l1)
    values = _by_blocks(series.coefficients, x)
    status = np.where(several, np.int8(Status.SEVERAL_CONTACTS), np.int8(Status.SOLVED))
    # Outside the window of the series, or without a series, each l1 is solved separately.
    beyond = ~((np.abs(x) <= 1.0) & (series.status == Status.SOLVED)[:, None] | several)
    result = np.flatnonzero(beyond.any(axis=0))
    # Block size for which the arrays stay in the cache. A safeguarded solve needs many samples per position.
    safeguarded_per_block = 2048
    size = max(1, safeguarded_per_block // len(l1))
    for part in (result[start : start + size] for start in range(0, result.size, size)):
        rows, known = exact_rows(pairing, l1[:, part])
        values[..., part] = np.where(beyond[:, part], rows, values[..., part])
        status[:, part] = np.where(beyond[:, part], known, status[:, part])
    return _limited(pairing, l1, values, status)


def _limited(
    pairing: FlankPair, l1: FloatArray, values: FloatArray, status: Codes
) -> tuple[FloatArray, Codes]:
    """Return rows and status at given l1; positions outside the limits are OFF_FLANK."""
    # Tolerance of the limits, in gap tolerances.
    limit_tolerance = 64.0
    values[0] = l1
    margin = values[ROW_COUNT:].min(axis=0)
    # Rows of a series with z of a contact on both members, mm.
    z_rows = slice(4, 6)
    if pairing.edges:
        margin = np.minimum(margin, edge_margins(pairing, values[:2], values[z_rows]).min(axis=0))
    off = margin < -limit_tolerance * gap_tolerance(pairing)
    if off.any():
        status[off & (status == Status.SOLVED)] = Status.OFF_FLANK
    return values[:ROW_COUNT], status


def rows_alone(pairing: FlankPair, l1: FloatArray) -> tuple[FloatArray, Codes] | None:
    """Return rows and status at given l1 (cases, positions), solved one by one, if each l1 has one contact
    near the flanks. This contact is then on the path, which need not be computed. None otherwise.
    """
    if (
        not (np.abs(pairing.layout.sin_angle) > NEARLY_PARALLEL_SINE).all()
        or (roots := sole_roots(pairing, l1)) is None
    ):
        return None
    rows, status = exact_rows(pairing, l1, roots)
    return None if status.any() else _limited(pairing, l1, rows, status)


def middles_of(groups: list[Group], l1: FloatArray) -> FloatArray:
    """Return PHASE (cases, 1) at mid-roll of the paths; without a path, at the middle of the given l1."""
    middles = np.empty((len(l1), 1))
    for group in groups:
        phase = group.series.coefficients[PHASE : PHASE + 1]
        middle = evaluate(phase, at_shares(group.series, group.ends, np.zeros(1)))[0]
        # Without a path: the contact in the middle of the given l1.
        if np.isnan(middle).any():
            asked = l1[group.cases]
            between = 0.5 * (asked.min(axis=-1, keepdims=True) + asked.max(axis=-1, keepdims=True))
            middle = np.where(np.isnan(middle), exact_rows(group.pairing, between)[0][PHASE], middle)
        middles[group.cases] = middle
    return middles


def _by_blocks(coefficients: FloatArray, parameter: FloatArray) -> FloatArray:
    """Return values (rows, cases, positions), computed in blocks of positions that stay in the cache."""
    cases, positions = coefficients.shape[1], parameter.shape[-1]
    # Block size for which the arrays stay in the cache.
    positions_per_block = 8192
    size = max(1, positions_per_block // cases)
    values = np.empty((len(coefficients), cases, positions))
    for start in range(0, positions, size):
        block = slice(start, start + size)
        values[..., block] = evaluate(coefficients, parameter[..., block])
    return values


def at_shares(series: PathSeries, ends: Ends, share: FloatArray) -> FloatArray:
    """Return series parameters x (cases, positions) at relative positions `share` in [-1, 1] from enter to
    leave.

    The position is measured in pinion roll, which is inverted by Halley's method. If the roll turns back
    along the path, the position is measured in x.
    """
    enter, leave, first, last = ends.x[:, :1], ends.x[:, 1:], ends.roll[:, :1], ends.roll[:, 1:]
    # Invert the roll by Halley's method; bisection for positions that do not converge.
    goal = 0.5 * ((first + last) + (last - first) * share)
    low, high = np.minimum(enter, leave), np.maximum(enter, leave)
    straight = x = 0.5 * ((enter + leave) + (leave - enter) * share)
    turns = ends.turning.any()
    rolls = with_derivative(series.coefficients[ROLL : ROLL + 1], 2)
    for _ in range(HALLEY_MAX_STEPS):
        value, rate, bend = evaluate(rolls, x)
        move = halley_step(value - goal, rate, bend)
        if turns:
            move[ends.turning] = 0.0
        x = np.minimum(np.maximum(x + move, low), high)
        far = np.abs(move) > LAST_HALLEY_STEP
        if not far.any():
            break
    if turns:
        x = np.where(ends.turning[:, None], straight, x)
    lost = np.flatnonzero(far.any(axis=-1)) if far.any() else ()
    if len(lost):
        x[lost] = inverted(series.coefficients[ROLL, lost], goal[lost], low[lost], high[lost])
    return x


def parameters_at_l1(series: PathSeries, ends: Ends, l1: FloatArray) -> tuple[FloatArray, Mask]:
    """Return series parameters x (cases, positions) at `l1` (cases, positions), mm, and where the path on the
    flanks has several contacts with this l1.

    If x is not a function of l1, only the path on the flanks is searched; NaN beyond it.
    """
    # Tolerance, relative to l1, by which a given position may miss the end of a path.
    end_tolerance = 1e-12
    x, several = (l1 - series.middle) / series.half, np.zeros(l1.shape, dtype=bool)
    for case in np.flatnonzero(np.isnan(series.half[:, 0]) & (ends.status == Status.SOLVED)):
        # Divide the path where l1 turns back, and invert l1 on each monotone part.
        both, (low, high) = with_derivative(series.coefficients[:1, case, None]), np.sort(ends.x[case])
        cuts = np.concatenate(([low], real_roots(both[1, 0], low, high), [high]))
        at_cuts, given = evaluate(both[:1], cuts)[0, 0], l1[case]
        for end in at_cuts[[0, -1]]:  # rounding must not separate an end from its path
            given = np.where(np.abs(given - end) <= end_tolerance * np.abs(both[0]).sum(), end, given)
        for k, (start, stop) in enumerate(pairwise(cuts)):
            least, most = np.sort(at_cuts[k : k + 2])
            here = (given >= least) & (given <= most)
            several[case, here] |= ~np.isnan(x[case, here])
            x[case, here] = inverted(both[0, 0], given[here], start, stop)
    return np.where(several, np.nan, x), several
