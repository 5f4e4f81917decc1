"""A pair in operation: the curve of its transmission error with hand-overs, and who carries it.

`first_contact` gives the gear's roll for every roll of the pinion, whichever tooth, flank or edge
carries. That curve repeats itself with the pinion's pitch. Within a cycle it consists of smooth
pieces, each carried in one way: by one tooth pair, on the flanks or on the edges of certain
limits. The rolls at which the carrier changes are found by repeated division; on the pieces the
curve is resolved by Gauss-Legendre points, so that Fourier coefficients do not suffer from kinks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.polynomial.legendre import legder, leggauss, legvander
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..design.model import Design, Errors, Pair, unchecked
from ..status import FirstStatus
from ..support.few_lines import few_lines
from .first_contact import first_contact, middle_roll

Numbers: TypeAlias = NDArray[np.int_]
Label: TypeAlias = Callable[[Numbers, FloatArray], Numbers]
"""Labels (n, rolls) of the cases with the numbers (n,) at rolls (n, rolls), rad."""
Part = TypeVar("Part", Pair, Errors)

SAMPLES = 96
"""Rolls of a pitch at which changes are looked for."""
DIVISIONS, CHANGE_WIDTH, MOST_CHANGES = 8, 1e-10, 64
"""Parts into which an interval with a change is divided at a time, until it is as narrow as this, in
pitches; changes in a cycle beyond which they are taken for rounding and divided no more."""
SHORT_PIECE = 1e-7
"""Pitches below which a piece is part of the change: rounding may change the carrier to and fro."""
NODES, BETWEEN = 20, 96
"""Gauss-Legendre points of a piece, and points at which their polynomial is integrated."""
EXTREMUM_PASSES = 4
"""Newton steps from the greatest and the least of 4 NODES points of a piece to its extremes."""


@dataclass(frozen=True, eq=False)
class Cycle:
    """One mesh cycle, from `start` (pinion roll, rad) over one pitch; batch axes lead.

    `changes` (..., k): rolls (rad) at which the carrier changes, ascending, filled up with NaN;
    the curve is smooth between. `hand_over` (..., k): whether another tooth pair takes over
    there. `mean`, `peak_to_peak` of the transmission error, rad. `harmonics` (..., n): complex
    Fourier coefficients, of which the moduli are the amplitudes (rad) at 1 ... n times the mesh
    frequency,

        error(roll) = mean + Re sum_k harmonics_k exp(2 pi i k (roll - start) / pitch).

    `edge_share`: the part of the cycle that edges carry. NaN, and no changes, where a position of
    the cycle has no first contact (`lost`)."""

    __repr__ = few_lines

    start: FloatArray
    pitch: float
    changes: FloatArray
    hand_over: NDArray[np.bool_]
    mean: FloatArray
    peak_to_peak: FloatArray
    harmonics: NDArray[np.complex128]
    edge_share: FloatArray
    lost: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Curve:
    """First contacts (intervals, rolls): the transmission error (rad), the carrier's number, its
    tooth pair, whether it is an edge, and whether it is in doubt what touches, if anything."""

    error: FloatArray
    carrier: Numbers
    pair: Numbers
    edge: NDArray[np.bool_]
    doubt: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Intervals:
    """Intervals of roll (n,), rad, of the cases with these numbers."""

    case: Numbers
    low: FloatArray
    high: FloatArray

    def parts(self, shares: FloatArray) -> FloatArray:
        """Rolls (n, shares) at shares 0 ... 1 of the intervals."""
        return self.low[:, None] + (self.high - self.low)[:, None] * shares


def curve_at(
    design: Design, flank: str, case: Numbers, roll: FloatArray, pairs: tuple[int, ...] | None = None
) -> Curve:
    """First contacts of the cases with the numbers `case` (n,) at the rolls (n, rolls)."""
    if design.batch_shape:
        first = first_contact(_at_cases(design, case), flank, roll, pairs)
    else:
        first = first_contact(design, flank, roll.reshape(-1), pairs)
    code = first.pair.astype(np.int64)
    for part in (*np.moveaxis(first.limit, -1, 0), *np.moveaxis(first.on_fillet, -1, 0)):
        code = 16 * code + part + 1
    edge = first.limit[..., 0] >= 0
    doubt = (first.status != FirstStatus.SOLVED) & (first.status != FirstStatus.NO_CONTACT)
    return Curve(
        error=first.transmission_error.reshape(roll.shape),
        carrier=code.reshape(roll.shape),
        pair=first.pair.reshape(roll.shape),
        edge=edge.reshape(roll.shape),
        doubt=doubt.reshape(roll.shape),
    )


def _at_cases(design: Design, case: Numbers) -> Design:
    """The cases with these numbers of a design with a batch, in one axis."""
    shape = design.batch_shape

    def part(given: Part) -> Part:
        arrays = {name: value for name, value in vars(given).items() if np.ndim(value) > 0}
        chosen = {name: np.broadcast_to(value, shape).reshape(-1)[case] for name, value in arrays.items()}
        return unchecked(given, **chosen)

    return replace(design, pair=part(design.pair), errors=part(design.errors))


def divided(found: Intervals, label: Label, least: float) -> Intervals:
    """The intervals over each of which the label changes, divided until narrower than `least`. An
    interval is divided at equal steps, and every part with a change goes on."""
    share = np.linspace(0.0, 1.0, DIVISIONS + 1)
    limit = MOST_CHANGES * max(1, np.unique(found.case).size)
    while 0 < found.case.size <= limit and float((found.high - found.low).max()) > least:
        roll = found.parts(share)
        found = with_change(found.case, roll, label(found.case, roll))
    return found


def with_change(case: Numbers, roll: FloatArray, labels: Numbers) -> Intervals:
    """Of the intervals between rolls (n, rolls) those whose ends have different labels."""
    row, column = np.nonzero(labels[:, 1:] != labels[:, :-1])
    return Intervals(case[row], roll[row, column], roll[row, column + 1])


def mesh_cycle(design: Design, flank: str, harmonics: int = 10) -> Cycle:
    """The transmission error of one mesh cycle, hand-overs and edges included.

    Members must be single; pair and errors may be arrays. About 500 first contacts a case.
    Raises ValueError for members of arrays and fewer than one harmonic."""
    if harmonics < 1:
        raise ValueError(f"harmonics must be at least 1, got {harmonics}")
    start = middle_roll(design, flank)
    shape, pitch = design.batch_shape, 2.0 * np.pi / int(design.pinion.teeth)
    start = np.broadcast_to(start, shape)
    case = np.arange(start.size)
    roll = start.reshape(-1, 1) + pitch * np.linspace(0.0, 1.0, SAMPLES + 1)
    samples = curve_at(design, flank, case, roll)
    lost = np.asarray(np.isnan(samples.error).any(axis=1))
    changed = with_change(case, roll, samples.carrier)
    changed = _only(changed, ~lost[changed.case])

    def carriers(cases: Numbers, rolls: FloatArray) -> Numbers:
        return curve_at(design, flank, cases, rolls).carrier

    changed = divided(changed, carriers, CHANGE_WIDTH * pitch)
    pieces = _pieces(changed, roll[:, 0], pitch)
    nodes, _ = leggauss(NODES)
    curve = curve_at(design, flank, pieces.case, pieces.parts(0.5 + 0.5 * nodes))
    lost[pieces.case[np.isnan(curve.error).any(axis=1)]] = True
    curve = replace(curve, error=np.where(lost[pieces.case, None], 0.0, curve.error))
    return _cycle(pieces, curve, start, pitch, harmonics, lost)


def _only(found: Intervals, kept: NDArray[np.bool_]) -> Intervals:
    return Intervals(found.case[kept], found.low[kept], found.high[kept])


def _pieces(changed: Intervals, start: FloatArray, pitch: float) -> Intervals:
    """The intervals between the changes of each case, in order."""
    each = np.arange(start.size)
    case = np.concatenate((each, changed.case, each))
    roll = np.concatenate((start, 0.5 * (changed.low + changed.high), start + pitch))
    order = np.lexsort((roll, case))
    case, roll = case[order], roll[order]
    kept = np.append(True, (case[1:] != case[:-1]) | (np.diff(roll) > SHORT_PIECE * pitch))
    case, roll = case[kept], roll[kept]
    joined = case[1:] == case[:-1]
    return Intervals(case[:-1][joined], roll[:-1][joined], roll[1:][joined])


def _series(values: FloatArray) -> FloatArray:
    """Legendre coefficients (pieces, NODES) from values at the Gauss-Legendre points of the pieces."""
    nodes, weights = leggauss(NODES)
    degree = np.arange(NODES)
    return np.asarray(values @ ((weights[:, None] * legvander(nodes, NODES - 1)) * (degree + 0.5)))


def _extremes(series: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Greatest and least value (pieces) of Legendre series (pieces, NODES) on [-1, 1]."""
    even = np.linspace(-1.0, 1.0, 4 * NODES + 1)
    dense = series @ legvander(even, NODES - 1).T
    slope, bend = legder(series, axis=1), legder(series, 2, axis=1)
    found = []
    for best, pick in ((dense.argmax(axis=1), np.maximum), (dense.argmin(axis=1), np.minimum)):
        place = even[best]
        low, high = np.maximum(place - 0.5 / NODES, -1.0), np.minimum(place + 0.5 / NODES, 1.0)
        for _ in range(EXTREMUM_PASSES):
            first = (legvander(place, NODES - 2) * slope).sum(axis=1)
            second = (legvander(place, NODES - 3) * bend).sum(axis=1)
            move = np.divide(first, second, out=np.zeros_like(first), where=second != 0.0)
            place = np.clip(place - move, low, high)
        refined = (legvander(place, NODES - 1) * series).sum(axis=1)
        found.append(pick(refined, dense[np.arange(best.size), best]))
    return found[0], found[1]


def _cycle(
    pieces: Intervals,
    curve: Curve,
    start: FloatArray,
    pitch: float,
    harmonics: int,
    lost: NDArray[np.bool_],
) -> Cycle:
    """Fourier coefficients and extremes from the pieces, by cases."""
    shape, cases = start.shape, start.size
    points, weights = leggauss(BETWEEN)
    series = _series(curve.error)
    values = series @ legvander(points, NODES - 1).T
    length = (pieces.high - pieces.low) / pitch
    phase = (pieces.parts(0.5 + 0.5 * points) - start.reshape(-1)[pieces.case, None]) / pitch
    turns = np.exp(-2.0j * np.pi * np.arange(harmonics + 1)[:, None, None] * phase)
    parts = 0.5 * length * ((turns * values) @ weights)
    coefficients = np.zeros((cases, harmonics + 1), dtype=complex)
    np.add.at(coefficients, pieces.case, parts.T)
    greatest, least = _extremes(series)
    high, low, edges = np.full(cases, -np.inf), np.full(cases, np.inf), np.zeros(cases)
    np.maximum.at(high, pieces.case, greatest)
    np.minimum.at(low, pieces.case, least)
    np.add.at(edges, pieces.case, np.where(curve.edge[:, NODES // 2], length, 0.0))
    changes, hand_over = _by_case(pieces, curve.pair[:, NODES // 2], cases)
    rows = (coefficients[:, 0].real, high - low, edges)
    mean, swing, share = (np.where(lost, np.nan, row).reshape(shape) for row in rows)
    waves = np.where(lost[:, None], np.nan, 2.0 * coefficients[:, 1:])
    return Cycle(
        start=start,
        pitch=pitch,
        changes=changes.reshape(*shape, -1),
        hand_over=hand_over.reshape(*shape, -1),
        mean=mean,
        peak_to_peak=swing,
        harmonics=waves.reshape(*shape, harmonics),
        edge_share=share,
        lost=lost.reshape(shape),
    )


def _by_case(pieces: Intervals, pair: Numbers, cases: int) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Changes (cases, most) and whether the tooth pair changes there."""
    inner = np.flatnonzero(pieces.case[1:] == pieces.case[:-1])
    case = pieces.case[inner]
    count = np.bincount(case, minlength=cases)
    column = np.arange(inner.size) - (np.cumsum(count) - count)[case]
    most = int(count.max(initial=0))
    changes, hand_over = np.full((cases, most), np.nan), np.zeros((cases, most), dtype=bool)
    changes[case, column] = pieces.high[inner]
    hand_over[case, column] = pair[inner] != pair[inner + 1]
    return changes, hand_over


def error_over_cycles(
    design: Design, flank: str, cycles: int = 3, points: int = 96
) -> tuple[FloatArray, FloatArray]:
    """Pinion rolls and transmission errors (..., cycles * points + 1), rad, at even steps over some
    mesh cycles. One is solved, the others are the same. NaN where there is no first contact.

    Raises ValueError for fewer than one cycle or point."""
    if min(cycles, points) < 1:
        raise ValueError(f"cycles and points must be at least 1, got {cycles} and {points}")
    start = np.broadcast_to(middle_roll(design, flank), design.batch_shape)[..., None]
    step = 2.0 * np.pi / int(design.pinion.teeth) / points
    error = first_contact(design, flank, start + step * np.arange(points)).transmission_error
    number = np.arange(cycles * points + 1)
    return start + step * number, error[..., number % points]
