"""A pair in operation: the curve of its transmission error with hand-overs, and who carries it.

`first_contact` gives the gear's roll for every roll of the pinion, whichever tooth, flank or edge
carries. That curve repeats itself with the pinion's pitch. Within a cycle it consists of smooth
pieces, each a polynomial in the pinion's roll (`pieces`): it is known at every roll, and its mean,
extremes and Fourier coefficients follow from the pieces, so that they do not suffer from kinks.

First contacts at some rolls tell who carries there. At others, most of them close to the pieces' ends, the
search is asked again: a piece that is late there, or does not meet the next, is divided.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray, Integers, Mask
from ..contact.parallel.lines import touches_along_lines
from ..design.field_limits import float64_of
from ..design.model import Design
from ..status import FirstStatus
from ..support.chebyshev import evaluate, polynomials, with_derivative
from ..support.few_lines import few_lines, html_table
from ..support.read_only import kept
from .first_contact import (
    FirstContact,
    Found,
    Grids,
    Mesh,
    Numbered,
    first_contact,
    found_at,
    found_with_others,
    grids_of,
    in_step,
    mesh_of,
    middle_roll,
    result_of,
)
from .overlooked import checked, earlier, overtaken
from .pieces import (
    DEGREE,
    QUANTITIES,
    SAMPLES,
    Pieces,
    Samples,
    changes_of,
    extremes,
    fitted,
    put_together,
    samples_of,
)

Waves: TypeAlias = NDArray[np.complex128]
BETWEEN = 96
"""Gauss-Legendre points at which the polynomial of a piece is integrated."""
MOST = 1000
"""Samples of a case on the average beyond which no piece is divided any more."""
CHECKS, ROUNDS = np.array((-0.95, 0.1, 1.0)), 8
"""Where in a piece, from -1 to 1, it is checked; how often pieces that fail are divided."""
CLOSER = np.array((-0.8, -0.6, -0.4, -0.2, 0.3, 0.5, 0.7))
"""Where first contacts are looked for besides in pieces that fail."""
LEAST, ASIDE = 2e-16, 1e-7
"""rad: coefficients that do not count in a gear roll; how far aside a piece is taken that ends or begins at a
roll."""
STILL = 1e-12
"""rad by which rounding moves a transmission error."""
CLOSE_SAMPLES = 64
"""Rolls of a pitch that are searched where divisions do not end."""
BESIDE = np.array((-1e-3, -1e-5, 1e-5, 1e-3))
"""Pitches from a jump at which first contacts are looked for that have not been seen."""


@dataclass(frozen=True, eq=False)
class MeshCycle:
    """One mesh cycle of a design's `flank`, from `start` (pinion roll, rad) over one pitch; batch axes lead.

    `at` gives first contacts at any roll. `changes` (..., k): rolls (rad) at which the carrier changes,
    ascending, filled up with NaN; the curve is smooth between. `hand_over` (..., k): whether another
    tooth pair takes over there. `mean`, `peak_to_peak` of the transmission error, rad. `harmonics`
    (..., n): complex Fourier coefficients, of which the moduli are the amplitudes (rad) at 1 ... n times
    the mesh frequency,

        error(roll) = mean + Re sum_k harmonics_k exp(2 pi i k (roll - start) / pitch).

    `edge_share`: the part of the cycle that edges carry, 0 where lines of contact do (`along_lines`). NaN,
    and no changes, where a position of the cycle has no first contact (`lost`), of which `status` (code of
    `FirstStatus`) says why; lost too is a pair without a common normal, to count errors from. `pieces` are
    the exact curve."""

    __repr__ = few_lines
    _repr_html_ = html_table

    design: Design = field(repr=False)
    flank: str
    start: FloatArray
    pitch: float
    changes: FloatArray
    hand_over: Mask
    mean: FloatArray
    peak_to_peak: FloatArray
    harmonics: Waves
    edge_share: FloatArray
    lost: Mask
    status: Integers
    pieces: Pieces = field(repr=False)
    mesh: Mesh = field(repr=False)
    phase: FloatArray = field(repr=False)

    @property
    def along_lines(self) -> Mask:
        """Say (batch shape) whether lines of contact of unmodified flanks carry, all along: first contacts
        are points of them, and edges their ends."""
        return np.asarray(conjugate_lines(self.design, self.flank) & (self.peak_to_peak < STILL))

    def at(self, pinion_roll: ArrayLike) -> FirstContact:
        """Give first contacts at pinion rolls (rad) of any shape, of a batch `(*batch, ...)`, in that shape.

        From the pieces, turned on by pitches; searched for anew if a `status` is not SOLVED. Raises
        ValueError for rolls that are not finite or of another shape."""
        roll = float64_of("pinion_roll", pinion_roll)
        shape = self.start.shape
        if roll.shape[: len(shape)] != shape:
            raise ValueError(f"pinion_roll must have a shape that begins with {shape}, got {roll.shape}")
        if not np.isfinite(roll).all():
            raise ValueError("pinion_roll must hold finite numbers")
        if (self.status != FirstStatus.SOLVED).any():
            first = first_contact(self.design, self.flank, roll.reshape(*shape, -1))
            return first.shaped(*roll.shape)
        case = np.arange(self.start.size).repeat(roll.size // max(1, self.start.size))
        piece, turns, values = self.located(case, roll.ravel())
        found = Found(
            f=values[0],
            place=values[1:3],
            meeting=values[3:5],
            limit=self.pieces.limit[:, piece],
            pair=self.pieces.pair[piece] - turns,
            status=np.full(case.size, FirstStatus.SOLVED, dtype=np.int8),
        )
        return result_of(self.mesh.at(case, roll.ravel()), self.phase[case], found, roll.shape)

    def gear_roll(self, pinion_roll: FloatArray, case: int = 0) -> FloatArray:
        """Give the gear roll (rad) of a single design, or of a SOLVED case of a batch, at pinion rolls
        of any shape, rad."""
        if self.status.flat[case] != FirstStatus.SOLVED:
            return self.at(pinion_roll).gear_roll
        roll = np.ravel(pinion_roll)
        return np.asarray(self.motion(case)(roll, roll)[0].reshape(np.shape(pinion_roll)))

    def motion(self, case: int = 0) -> Callable[[FloatArray, FloatArray], FloatArray]:
        """Give a function of rolls (n,), rad, that gives the gear's roll (rad) of a single design, or of a
        SOLVED case of a batch, and its rate over the pinion's (2, n); at a change of the carrier those on the
        side of other rolls (n,), its second argument."""
        piece, start, pitch = np.flatnonzero(self.pieces.case == case), self.mesh.roll[case], self.pitch
        low, high = self.pieces.low[piece] - start, self.pieces.high[piece] - start
        series, ratio = self.phase_series()[piece], self.mesh.pitch[1] / self.mesh.pitch[0]
        last = max(1, np.flatnonzero((np.abs(series) > LEAST).any(axis=0))[-1])
        both = with_derivative(series[None, :, : last + 1]).transpose(2, 0, 1).copy()

        def at(roll: FloatArray, towards: FloatArray) -> FloatArray:
            """Give roll and rate of the gear."""
            aside = np.minimum(np.maximum(0.25 * (towards - roll), -ASIDE), ASIDE)
            turned = np.remainder(roll + aside - start, pitch)
            own = np.maximum(low.searchsorted(turned, side="right") - 1, 0)
            length = (high - low)[own]
            powers = polynomials(2.0 * (turned - aside - low[own]) / length - 1.0, len(both) - 1)
            phase, rate = (both.take(own, axis=2) * powers[:, None]).sum(axis=0)
            return np.array((phase - ratio * roll, 2.0 * rate / length - ratio))

        return at

    def phase_series(self) -> FloatArray:
        """Give Chebyshev coefficients (pieces, DEGREE + 1) of gear roll plus N1/N2 pinion roll, rad."""
        series: FloatArray = self.mesh.other.sigma / self.mesh.lever * self.pieces.coefficients[0]
        series[:, 0] += self.mesh.phase[self.pieces.case]
        return series

    def located(
        self, case: Integers, roll: FloatArray, rows: int | None = None
    ) -> tuple[Integers, Integers, FloatArray]:
        """Give pieces (n,) at rolls (n,) of the cases, pitches beyond the cycle, `Pieces.values_at` (rows,
        n)."""
        turns = np.floor((roll - self.mesh.roll[case]) / self.pitch).astype(np.int64)
        piece = self.pieces.number(self.mesh, case, roll - turns * self.pitch)
        return piece, turns, self.pieces.values_at(piece, roll - turns * self.pitch, rows)


def mesh_cycle(design: Design, flank: str = "right", harmonics: int = 10) -> MeshCycle:
    """Find the transmission error of one mesh cycle, hand-overs and edges included.

    Parameters
    ----------
    design : Design
        Members must be single; pair and errors may be arrays.
    flank : {'right', 'left'}
    harmonics : int
        Of the mesh frequency.

    Returns
    -------
    MeshCycle
        Its exact pieces, evaluated at any roll by `at`.

    Raises
    ------
    ValueError
        For members of arrays and fewer than one harmonic.
    """
    return cycle_and_pairs(design, flank, harmonics, False)[0]


def cycle_and_pairs(
    design: Design, flank: str, harmonics: int, each: bool = True
) -> tuple[MeshCycle, Grids, Samples, Numbered]:
    """Give the mesh cycle with the points scanned and its samples; and the contacts of `each` tooth pair that
    is not much later than the first, alone, with the numbers of their samples."""
    if harmonics < 1:
        raise ValueError(f"harmonics must be at least 1, got {harmonics}")
    start = np.broadcast_to(middle_roll(design, flank), design.batch_shape)
    mesh, phase = mesh_of(design, flank, start[..., None], start)
    grids, shape = grids_of(mesh, design, flank), start.shape
    if np.isnan(phase).any():
        mesh = in_step(mesh, np.isnan(phase)[:, None], grids)
    case, roll = _rolls_of(mesh)
    first, near, alone = found_with_others(mesh.at(case, roll), grids, each=each)
    samples = samples_of(case, roll, first)
    pieces, status = _pieces_of(mesh, grids, samples, samples_of(case[near[0]], roll[near[0]], near[1]))
    lost = (status != FirstStatus.SOLVED) | np.isnan(phase)
    waves, swing, edges = _sums(mesh, pieces, harmonics)
    waves[lost], swing[lost], edges[lost] = np.nan, np.nan, np.nan
    changes, hand_over = changes_of(pieces, start.size)
    cycle = MeshCycle(
        design=design,
        flank=flank,
        start=start,
        pitch=mesh.pitch[0],
        changes=changes.reshape(*shape, -1),
        hand_over=hand_over.reshape(*shape, -1),
        mean=waves[:, 0].real.reshape(shape),
        peak_to_peak=swing.reshape(shape),
        harmonics=(2.0 * waves[:, 1:]).astype(np.complex128).reshape(*shape, harmonics),
        edge_share=edges.reshape(shape),
        lost=lost.reshape(shape),
        status=status.reshape(shape),
        pieces=pieces,
        mesh=mesh,
        phase=phase,
    )
    cycle = replace(cycle, edge_share=np.where(cycle.along_lines, 0.0, cycle.edge_share))
    return cycle, grids, samples, alone


def conjugate_lines(design: Design, flank: str) -> Mask:
    """Say (batch shape) whether unmodified flanks touch along lines, of all tooth pairs at once."""
    curved = np.zeros(design.batch_shape, dtype=bool)
    for member in design.members:
        curved = curved | (np.asarray(member.tool.parabola) != 0.0)
    return ~curved if curved.all() else np.asarray(touches_along_lines(design, flank) & ~curved)


@kept(1)
def _gauss_points() -> tuple[FloatArray, FloatArray]:
    return leggauss(BETWEEN)


def _sums(mesh: Mesh, pieces: Pieces, harmonics: int) -> tuple[Waves, FloatArray, FloatArray]:
    """Give, of each case, Fourier coefficients (cases, harmonics + 1) of the transmission error, its peak to
    peak, rad, and the share that edges carry."""
    cases, errors = mesh.roll.size, mesh.other.sigma / mesh.lever * pieces.coefficients[:1]
    points, weights = _gauss_points()
    length = (pieces.high - pieces.low) / mesh.pitch[0]
    share = (pieces.rolls(points) - mesh.roll[pieces.case, None]) / mesh.pitch[0]
    turns = np.exp(-2.0j * np.pi * np.arange(harmonics + 1)[:, None, None] * share)
    waves = np.zeros((cases, harmonics + 1), dtype=np.complex128)
    np.add.at(waves, pieces.case, (0.5 * length * ((turns * evaluate(errors, points)[0]) @ weights)).T)
    high, low, edges = np.full(cases, -np.inf), np.full(cases, np.inf), np.zeros(cases)
    for extreme, best, ends in zip((np.maximum, np.minimum), (high, low), extremes(errors), strict=True):
        extreme.at(best, pieces.case, ends)
    np.add.at(edges, pieces.case, np.where(pieces.limit[0] >= 0, length, 0.0))
    return waves, high - low, np.minimum(edges, 1.0)


def _sampled(mesh: Mesh, grids: Grids, case: Integers, roll: FloatArray) -> Samples:
    return samples_of(case, roll, found_at(mesh.at(case, roll), grids))


def _rolls_of(mesh: Mesh, number: int = SAMPLES) -> tuple[Integers, FloatArray]:
    """Give cases and rolls (n,), rad, at which first contacts tell the carriers over a pitch from the rolls
    of a mesh on, of which each is a case: `number` a pitch, and its end."""
    share, cases = np.linspace(0.0, 1.0, number + 1), mesh.roll.size
    case = np.arange(cases).repeat(share.size)
    return case, mesh.roll[case] + np.tile(mesh.pitch[0] * share, cases)


def _pieces_of(mesh: Mesh, grids: Grids, samples: Samples, near: Samples) -> tuple[Pieces, Integers]:
    """Give pieces over a pitch of the pinion from the rolls of a mesh on, of which each is a case, and the
    status of the cases, codes of `FirstStatus`: of the first roll that is not SOLVED. Such a case has no
    pieces. `samples`: the first contacts at `_rolls_of` the mesh; `near`: all contacts found there."""
    pieces, status = _divided(mesh, grids, samples, near)
    if (lost := status == FirstStatus.NOT_CONVERGED).any():  # a carrier may have been overlooked all along
        case, roll = _rolls_of(mesh, CLOSE_SAMPLES)
        samples = _sampled(mesh, grids, case[lost[case]], roll[lost[case]])
        closer, again = _divided(mesh, grids, samples, near)
        pieces, status = in_order([pieces, closer]), np.where(lost, again, status)
    return pieces, status


def _divided(mesh: Mesh, grids: Grids, samples: Samples, near: Samples) -> tuple[Pieces, Integers]:
    """Give pieces with the carriers of the samples, divided until all hold, and the status of all cases."""
    cases = mesh.roll.size
    status, done = np.zeros(cases, dtype=np.int64), []
    for count in range(ROUNDS):
        bad = np.flatnonzero(samples.found.status != FirstStatus.SOLVED)[::-1]
        status[samples.case[bad]] = samples.found.status[bad]
        samples = samples.pick(status[samples.case] == FirstStatus.SOLVED)
        if not 0 < samples.case.size <= MOST * cases:
            break
        pieces = fitted(mesh, samples)
        if count == 0:  # many samples know it better than few checks
            piece = pieces.number(mesh, samples.case, samples.roll)
            samples, bad = checked(mesh, pieces, piece, samples, True)
            checks = samples.pick(np.zeros(0, dtype=np.int64))
        else:
            piece, roll = np.arange(pieces.case.size).repeat(CHECKS.size), pieces.rolls(CHECKS).ravel()
            checks = _sampled(mesh, grids, pieces.case[piece], roll)
            checks, bad = checked(mesh, pieces, piece, checks, count < ROUNDS // 2)
        jumps, mended, samples = overtaken(mesh, samples, pieces)
        bad = np.union1d(bad, np.append(jumps, jumps + 1))
        early = earlier(mesh, pieces, near)
        failed = np.isin(np.arange(cases), np.concatenate((pieces.case[bad], mended, early.case)))
        if failed.any():
            checks = checks.and_also(_between(mesh, grids, samples, pieces, bad, jumps)).and_also(early)
        done.append(pieces.pick(~failed[pieces.case]))
        samples = samples.pick(failed[samples.case]).and_also(checks.pick(failed[checks.case]))
    status[samples.case] = np.where(status[samples.case], status[samples.case], FirstStatus.NOT_CONVERGED)
    return in_order(done), status


def _between(
    mesh: Mesh, grids: Grids, samples: Samples, pieces: Pieces, bad: Integers, jumps: Integers
) -> Samples:
    """Give first contacts at more rolls within the pieces `bad` and beside those at whose end the curve
    jumps."""
    start, stop = samples.ends(pieces.case[jumps])
    beside = np.clip(pieces.high[jumps, None] + mesh.pitch[0] * BESIDE, start[:, None], stop[:, None])
    case = np.append(pieces.case[bad].repeat(CLOSER.size), pieces.case[jumps].repeat(BESIDE.size))
    return _sampled(mesh, grids, case, np.append(pieces.rolls(CLOSER)[bad], beside))


def in_order(parts: list[Pieces]) -> Pieces:
    """Join pieces, in order of case and roll."""
    none, no, rows = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((2, 0), dtype=np.int8)
    empty = Pieces(none, no, no, np.zeros((QUANTITIES, 0, DEGREE + 1)), none, rows, rows > 0)
    pieces = put_together([empty, *parts])
    return pieces.pick(np.lexsort((pieces.low, pieces.case)))
