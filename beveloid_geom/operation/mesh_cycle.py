"""A pair in operation: the curve of its transmission error with hand-overs, and who carries it.

`first_contact` gives the gear's roll for every roll of the pinion, whichever tooth, flank or edge
carries. That curve repeats itself with the pinion's pitch. Within a cycle it consists of smooth
pieces, each a polynomial in the pinion's roll (`pieces`): it is known at every roll, and its mean,
extremes and Fourier coefficients follow from the pieces, so that they do not suffer from kinks.

First contacts at some rolls tell who carries there. At others, most of them close to the pieces' ends, the
search is asked again: a piece that is late there, or does not meet the next, is divided.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray, Integers, Mask
from ..design.field_limits import float64_of
from ..design.model import Design
from ..status import FirstStatus
from ..support.chebyshev import evaluate
from ..support.few_lines import few_lines, html_table
from ..support.read_only import kept
from .first_contact import (
    FirstContact,
    Found,
    Grids,
    Mesh,
    first_contact,
    found_at,
    found_with_pairs,
    grids_of,
    in_step,
    mesh_of,
    middle_roll,
    result_of,
)
from .least_clearance import FEASIBLE
from .pieces import (
    DEGREE,
    QUANTITIES,
    SAMPLES,
    Pieces,
    Samples,
    changes_of,
    extremes,
    fitted,
    held_to,
    holding,
    put_together,
    tails_of,
)

Waves: TypeAlias = NDArray[np.complex128]
BETWEEN = 96
"""Gauss-Legendre points at which the polynomial of a piece is integrated."""
MOST = 1000
"""Samples of a case on the average beyond which no piece is divided any more."""
PLACED = np.array((1e-14, 1e-11, 1e-11, 1e-11, 1e-11))
"""What the last coefficients of f, over the lever, and of places, over the tooth depth, may reach while there
are rounds left."""
CHECKS, ROUNDS = np.array((-0.95, 0.1, 1.0)), 8
"""Where in a piece, from -1 to 1, it is checked; how often pieces that fail are divided."""
CLOSER = np.array((-0.8, -0.6, -0.4, -0.2, 0.3, 0.5, 0.7))
"""Where first contacts are looked for besides in pieces that fail."""
CHECKED = 3e-11
"""rad of the gear's roll by which a piece may lie behind a first contact."""
CLOSE_SAMPLES = 64
"""Rolls of a pitch that are searched where divisions do not end, or at which a carrier may come back."""
AWAY = 1.0
"""Lengths of a piece beyond its ends at which it is asked whether its carrier comes back."""
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

    `edge_share`: the part of the cycle that edges carry. NaN, and no changes, where a position of
    the cycle has no first contact (`lost`), of which `status` (code of `FirstStatus`) says why; lost too
    is a pair without a common normal, to count errors from. `pieces` are the exact curve."""

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
        roll, mesh = np.asarray(pinion_roll).ravel(), self.mesh
        f = self.located(np.full(roll.size, case), roll, 1)[2][0]
        turned = mesh.phase[case] - mesh.pitch[1] / mesh.pitch[0] * roll + mesh.other.sigma * f / mesh.lever
        return np.asarray(turned.reshape(np.shape(pinion_roll)))

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
) -> tuple[MeshCycle, Grids, Samples, tuple[Integers, Found]]:
    """Give the mesh cycle with the points scanned and its samples; and the contacts of `each` tooth pair that
    is not much later than the first, alone, with the numbers of their samples."""
    if harmonics < 1:
        raise ValueError(f"harmonics must be at least 1, got {harmonics}")
    start = np.broadcast_to(middle_roll(design, flank), design.batch_shape)
    mesh, phase = mesh_of(design, flank, start[..., None], start)
    grids, shape = grids_of(mesh, design, flank), start.shape
    if np.isnan(phase).any():
        mesh = in_step(mesh, np.isnan(phase)[:, None], grids)
    case, roll = _samples_of(mesh)
    first, position, alone = found_with_pairs(mesh.at(case, roll), grids, each=each)
    samples = Samples(case, roll, np.zeros(case.size, dtype=bool), first)
    pieces, status = _pieces_of(mesh, grids, samples)
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
    return cycle, grids, samples, (position, alone)


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
    return Samples(case, roll, np.zeros(case.size, dtype=bool), found_at(mesh.at(case, roll), grids))


def _samples_of(mesh: Mesh, number: int = SAMPLES) -> tuple[Integers, FloatArray]:
    """Give cases and rolls (n,), rad, at which first contacts tell the carriers over a pitch from the rolls
    of a mesh on, of which each is a case: `number` a pitch, and its end."""
    share, cases = np.linspace(0.0, 1.0, number + 1), mesh.roll.size
    case = np.arange(cases).repeat(share.size)
    return case, mesh.roll[case] + np.tile(mesh.pitch[0] * share, cases)


def _pieces_of(mesh: Mesh, grids: Grids, samples: Samples) -> tuple[Pieces, Integers]:
    """Give pieces over a pitch of the pinion from the rolls of a mesh on, of which each is a case, and the
    status of the cases, codes of `FirstStatus`: of the first roll that is not SOLVED. Such a case has no
    pieces. `samples`: the first contacts at `_samples_of` the mesh."""
    pieces, status = _divided(mesh, grids, samples)
    if (lost := status == FirstStatus.NOT_CONVERGED).any():  # a carrier may have been overlooked all along
        case, roll = _samples_of(mesh, CLOSE_SAMPLES)
        closer, again = _divided(mesh, grids, _sampled(mesh, grids, case[lost[case]], roll[lost[case]]))
        pieces, status = in_order([pieces, closer]), np.where(lost, again, status)
    return pieces, status


def _divided(mesh: Mesh, grids: Grids, samples: Samples) -> tuple[Pieces, Integers]:
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
        checks, good = _checked(mesh, grids, pieces, count < ROUNDS // 2)
        jumps, samples = _overtaken(mesh, samples, pieces)
        bad = np.union1d(np.flatnonzero(~good.all(axis=1)), np.append(jumps, jumps + 1))
        back = _coming_back(mesh, pieces)
        failed = np.isin(np.arange(cases), np.append(pieces.case[bad], back.case))
        if failed.any():
            checks = checks.and_also(_between(mesh, grids, samples, pieces, bad, jumps)).and_also(back)
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


def _checked(mesh: Mesh, grids: Grids, pieces: Pieces, strict: bool) -> tuple[Samples, Mask]:
    """Give first contacts at other rolls, and whether (n, CHECKS) the pieces are as early there and, if
    `strict`, their places known. A piece may be earlier, within all limits: a search missed its contact, and
    what it found is left out."""
    roll, each = pieces.rolls(CHECKS), np.arange(pieces.case.size)
    checks = _sampled(mesh, grids, pieces.case.repeat(roll.shape[1]), roll.ravel())
    values, bound = pieces.values(each, roll), CHECKED * mesh.lever
    behind = values[0] - checks.found.f.reshape(roll.shape)
    earlier = np.asarray(behind < -bound)
    if earlier.any():
        piece = each.repeat(roll.shape[1])
        there, within = _moved(mesh, checks.case, checks.roll, pieces, piece, values[1:3].reshape(2, -1))
        earlier &= within.reshape(roll.shape)
        earlier &= np.abs(values[0] - there[0].reshape(roll.shape)) <= bound
    sizes = np.array((mesh.lever, *[mesh.own.tip - mesh.own.root] * (QUANTITIES - 1)))
    most = PLACED * sizes if strict else np.full(QUANTITIES, np.inf)
    placed = np.asarray((tails_of(pieces) <= most[:, None]).all(axis=0))
    good = np.asarray(((np.abs(behind) <= bound) | earlier) & placed[:, None])
    checks = replace(checks, cut=~good.ravel())
    return checks.pick(~earlier.ravel()), good


def _moved(
    mesh: Mesh, case: Integers, roll: FloatArray, pieces: Pieces, piece: Integers, place: FloatArray
) -> tuple[FloatArray, Mask]:
    """Give contacts near places (2, n) at rolls that are carried as the pieces: f, s1, z1, s2, z2 (5, n), and
    whether they lie within the limits."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        task = mesh.at(case, roll).task(np.arange(case.size), pieces.pair[piece])
        values = held_to(task, place, pieces.limit[:, piece])
        margin = np.where(holding(pieces.limit[:, piece]), 0.0, values[QUANTITIES:])
    return values[:QUANTITIES], np.asarray((margin >= -FEASIBLE * task.depth).all(axis=0))


def _coming_back(mesh: Mesh, pieces: Pieces) -> Samples:
    """Give contacts beside the pieces, carried as these, that are earlier than the pieces there: a carrier
    that comes back for less than the distance of two samples is not seen by those."""
    piece = np.arange(pieces.case.size).repeat(CLOSE_SAMPLES)
    share = np.tile(np.arange(CLOSE_SAMPLES) / CLOSE_SAMPLES, pieces.case.size)
    roll = mesh.roll[pieces.case[piece]] + mesh.pitch[0] * share
    away = np.maximum(pieces.low[piece] - roll, roll - pieces.high[piece])
    beside = (away > 0.0) & (away < AWAY * (pieces.high - pieces.low)[piece])
    piece, roll = piece[beside], roll[beside]
    case = pieces.case[piece]
    values, within = _moved(mesh, case, roll, pieces, piece, pieces.values_at(piece, roll)[1:3])
    there = pieces.values_at(pieces.number(mesh, case, roll), roll, 1)[0]
    row = np.flatnonzero(within & (values[0] < there - CHECKED * mesh.lever))
    values, piece = values[:, row], piece[row]
    found = Found(
        f=values[0],
        place=values[1:3],
        meeting=values[3:],
        limit=pieces.limit[:, piece],
        pair=pieces.pair[piece],
        status=np.full(row.size, FirstStatus.SOLVED, dtype=np.int8),
    )
    return Samples(case[row], roll[row], np.zeros(row.size, dtype=bool), found)


def _overtaken(mesh: Mesh, samples: Samples, pieces: Pieces) -> tuple[Integers, Samples]:
    """Give pieces at whose end the curve jumps, as a contact between was not seen, or an earlier one missed;
    and the samples, of the pieces behind those that their neighbours are carried by, if these are earlier."""
    inner = np.flatnonzero(pieces.case[1:] == pieces.case[:-1])
    ends = np.stack([pieces.values_at(inner + k, pieces.high[inner]) for k in (0, 1)])
    jump, found = ends[0, 0] - ends[1, 0], samples.found
    jumps = np.flatnonzero(np.abs(jump) > CHECKED * mesh.lever)
    early = (jump[jumps] > 0.0).astype(int)
    own = pieces.number(mesh, samples.case, samples.roll)
    which, row = np.nonzero(own == (inner[jumps] + 1 - early)[:, None])
    piece, place = (inner[jumps] + early)[which], ends[early, 1:3, jumps].T[:, which]
    values, within = _moved(mesh, samples.case[row], samples.roll[row], pieces, piece, place)
    better = np.flatnonzero(within & (values[0] < found.f[row]))
    better = better[np.argsort(-values[0, better], kind="stable")]  # of two neighbours the earlier comes last
    row, values, piece = row[better], values[:, better], piece[better]
    found.f[row], found.place[:, row], found.meeting[:, row] = values[0], values[1:3], values[3:]
    found.limit[:, row], found.pair[row] = pieces.limit[:, piece], pieces.pair[piece]
    return inner[jumps], samples


def in_order(parts: list[Pieces]) -> Pieces:
    """Join pieces, in order of case and roll."""
    none, no, rows = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((2, 0), dtype=np.int8)
    empty = Pieces(none, no, no, np.zeros((QUANTITIES, 0, DEGREE + 1)), none, rows, rows > 0)
    pieces = put_together([empty, *parts])
    return pieces.pick(np.lexsort((pieces.low, pieces.case)))
