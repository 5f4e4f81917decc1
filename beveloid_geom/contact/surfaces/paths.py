"""Paths of contact of flanks given as surfaces: search, positions and rows of the result.

The curve of contact is solved at positions s1 over the flank of the pinion. Where this does not show the part
on the flanks completely, all curves are searched on a grid and traced (`tracing`). Positions on the path and
its ends are exact solutions of the equations of tangency; nothing is interpolated in the result.

Members are single, the placement (errors, offset, shaft angle, mounting) may be a batch. Batches of members
are solved for each pair of different members.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask
from ...design.model import Design
from ...gear.rack import Rack, rack_of, rack_point
from ...status import Status
from ...support.frozen_arrays import cached
from ..ends import Ends, no_ends
from ..flank_pair import generated_pairing
from ..path_polynomial import NORMAL, PHASE, POINT, ROLL, ROW_COUNT
from .curve import MARGINS, NODE_COUNT, STATE, Curve, curve_over_s1, dense
from .limits import Problem, margins_at
from .positions import positions_on
from .problems import problems_of
from .refinement import with_more_samples
from .segments import Segment, empty_segment, refined, segments_of
from .tangency import Contacts, given_row, meshing_start, solve
from .tracing import on_curve, seeds_of, traced

POSITIONS_PER_BLOCK = 8192
"""Number of contacts for which the arrays stay in the cache."""


@dataclass(frozen=True, eq=False)
class SurfacePaths:
    """Paths of cases with the same two members: the numbers of the cases, problem, segments and racks."""

    cases: Integers
    problem: Problem
    segment: Segment
    racks: tuple[Rack, Rack]

    def blocks(self, positions: int) -> Iterator[SurfacePaths]:
        """Yield blocks of cases whose arrays stay in the cache with `positions` contacts per case."""
        for index in _blocks(self.cases.size, positions):
            segment = _picked(self.segment, index)
            yield SurfacePaths(self.cases[index], self.problem.cases(index), segment, self.racks)


def segments_on_flanks(problem: Problem, undefined: Mask) -> Segment:
    """Return the segments of all cases; `undefined` (cases,) have no flanks or no mounting."""
    blocks = _blocks(undefined.size, NODE_COUNT)
    return _joined([_block(problem.cases(index), undefined[index]) for index in blocks])


def _blocks(cases: int, positions: int) -> list[Integers]:
    """Return the numbers of the cases in blocks of POSITIONS_PER_BLOCK positions."""
    size = max(1, POSITIONS_PER_BLOCK // positions)
    return [np.arange(start, min(start + size, cases)) for start in range(0, cases, size)]


def _block(problem: Problem, undefined: Mask) -> Segment:
    curve = curve_over_s1(problem)
    segment, decided = segments_of(problem, curve)
    if problem.surfaces.measured or problem.generated_lines:
        decided &= refined(problem, segment)
    doubtful = np.flatnonzero(~decided & ~undefined)
    if doubtful.size:
        results = _sampled_closer(problem.cases(doubtful), curve.cases(doubtful))
        left = np.array([place for place in range(doubtful.size) if place not in results], dtype=int)
        if left.size:
            traced_segments = _traced_inside(problem.cases(doubtful[left]), curve.cases(doubtful[left]))
            results |= {int(left[place]): one for place, one in traced_segments.items()}
        order = np.arange(decided.size)
        parts = [_picked(segment, order[k : k + 1]) for k in order.tolist()]
        for place, case in enumerate(doubtful.tolist()):
            parts[case] = results.get(place) or _searched(problem.cases(order[case : case + 1]))
        segment = _joined(parts)
    segment.status[undefined] = Status.UNDEFINED
    return segment


def _sampled_closer(problem: Problem, curve: Curve) -> dict[int, Segment]:
    """Return the segments of cases that are decided by more samples of their curves.

    The result is empty on measured flanks, whose random deviations may cause several curves. It is also empty
    if the flanks without their modifications would touch along lines (`Problem.generated_lines`): contacts at
    given s1 are then seldom found."""
    if problem.surfaces.measured or problem.generated_lines:
        return {}
    # Number of times that intervals are divided.
    rounds = 4
    decided_segments: dict[int, Segment] = {}
    left = np.arange(len(curve.x))
    for _ in range(rounds):
        if not left.size:
            break
        curve = with_more_samples(problem.cases(left), curve)
        segment, decided = segments_of(problem.cases(left), curve)
        # Where the roll turns back, positions are given by the length of the curve, which tracing follows.
        decided &= (segment.status == Status.SOLVED) & ~segment.turning
        decided_segments |= {int(left[k]): _picked(segment, np.array([k])) for k in np.flatnonzero(decided)}
        left, curve = left[~decided], curve.cases(np.flatnonzero(~decided))
    return decided_segments


def _traced_inside(problem: Problem, curve: Curve) -> dict[int, Segment]:
    """Return the segments of cases whose curve could be traced from its sample that is farthest inside.

    The result is empty on measured flanks, whose random deviations may cause several curves: `_searched`
    finds the longest one."""
    if problem.surfaces.measured:
        return {}
    margin = np.nan_to_num(curve.value[MARGINS].min(axis=0), nan=-np.inf)
    cases = np.flatnonzero(margin.max(axis=-1) > 0.0)
    if not cases.size:
        return {}
    part = problem.cases(cases)
    along, complete = traced(part, curve.value[STATE][:, cases, margin[cases].argmax(axis=-1)])
    segment, decided = segments_of(part, along)
    decided &= complete & (segment.status == Status.SOLVED)
    return {int(cases[k]): _picked(segment, np.array([k])) for k in np.flatnonzero(decided)}


def _picked(segment: Segment, index: Integers) -> Segment:
    """Return the segments of the cases `index`."""
    values = {
        name: value[:, index] if name in ("state", "knots") else value[index]
        for name, value in vars(segment).items()
    }
    return Segment(**values)


def _joined(parts: list[Segment]) -> Segment:
    """Return the segments of several sets of cases, with knots of one number."""
    if len(parts) == 1:
        return parts[0]
    width = max(part.x.shape[-1] for part in parts)
    values = {}
    for name in vars(parts[0]):
        rows = [getattr(part, name) for part in parts]
        if name in ("x", "knots"):
            rows = [
                np.pad(row, [(0, 0)] * (row.ndim - 1) + [(0, width - row.shape[-1])], mode="edge")
                for row in rows
            ]
        values[name] = np.concatenate(rows, axis=1 if name in ("state", "knots") else 0)
    return Segment(**values)


def _searched(problem: Problem) -> Segment:
    """Return the segment of a single case from all curves on its flanks."""
    seeds, all_known = seeds_of(problem)
    best: Segment | None = None
    pieces, doubtful, closed_span = 0, not all_known and not seeds.size, 0.0
    while seeds.shape[1]:
        curve, complete = traced(problem, seeds[:, :1])
        if np.isnan(curve.value).all():
            doubtful, seeds = True, seeds[:, 1:]
            continue
        segment, decided = segments_of(problem, curve)
        seeds = seeds[:, 1:][:, ~on_curve(curve, problem, seeds[:, 1:])]
        inside = (dense(problem, curve)[1][MARGINS].min(axis=0) >= 0.0).any()
        if inside and not (decided[0] and complete[0]):
            # A closed curve on the flanks is not a path, but counts as a segment. Its ends meet; those of a
            # curve that was lost while it was traced do not.
            chord = (curve.value[:3, 0, -1] - curve.value[:3, 0, 0]) / problem.scale
            closed = np.linalg.norm(chord) <= 0.1 * curve.x[0, -1]
            if closed and (curve.value[MARGINS].min(axis=0) >= 0.0).all():
                pieces, closed_span = pieces + 1, max(closed_span, float(np.ptp(curve.value[2])))
            else:
                doubtful = True
        if segment.status[0] == Status.SOLVED:
            pieces += int(segment.pieces[0])
            if best is None or segment.span[0] > best.span[0]:
                best = segment
    if best is not None and problem.surfaces.measured:
        doubtful |= not refined(problem, best)[0]
    endless = closed_span > (0.0 if best is None else float(best.span[0]))
    if best is None or doubtful or endless:
        best = empty_segment(1, 1) if best is None else best
        best.status[:] = Status.ENDLESS if endless else Status.NOT_CONVERGED if doubtful else Status.OFF_FLANK
        if doubtful or endless:
            for values in (best.state, best.span, best.knots, best.x):
                values[...] = np.nan
            best.limit[...], best.pieces[...] = -1, 0
        return best
    best.pieces[:] = pieces
    return best


def surface_paths(design: Design, flank: str, undercut: bool = True) -> list[SurfacePaths]:
    """Return the paths of all cases of a design, one group for each pair of different members.

    Parameters
    ----------
    design : Design
        The paths of single designs are cached.
    flank : {'right', 'left'}
    undercut : bool
        Whether undercut limits the flanks.
    """
    find = _surface_paths if design.batch_shape else _cached_paths
    return find(design, flank, undercut)


def _surface_paths(design: Design, flank: str, undercut: bool) -> list[SurfacePaths]:
    pairing, result = generated_pairing(design, flank, undercut), []
    for single, cases, problem in problems_of(design, flank, pairing):
        segment = segments_on_flanks(problem, pairing.undefined[cases])
        racks = rack_of(single.pinion, flank), rack_of(single.gear, flank)
        result.append(SurfacePaths(cases, problem, segment, racks))
    return result


_cached_paths = cached(16)(_surface_paths)


def surface_ends(paths: list[SurfacePaths], count: int) -> Ends:
    """Return the ends of the paths of all cases."""
    ends = no_ends(np.empty(count, dtype=np.int8))
    for path in paths:
        segment = path.segment
        void = np.full((path.cases.size, 2), np.nan)
        path_ends = Ends(
            x=void,
            l=segment.state[[0, 3]],
            roll=segment.state[2],
            limit=segment.limit,
            span=segment.span,
            turning=segment.turning,
            pieces=segment.pieces,
            status=segment.status,
        )
        ends.put(path.cases, path_ends)
    return ends


def rows_between_ends(paths: list[SurfacePaths], count: int, share: FloatArray) -> tuple[FloatArray, Codes]:
    """Return rows (ROW_COUNT, cases, positions) and status at fractions `share` of the path from enter to
    leave.

    PHASE is relative to the middle of the path.
    """
    table = np.full((ROW_COUNT, count, share.size), np.nan)
    status = np.empty((count, share.size), dtype=np.int8)
    for path in (part for group in paths for part in group.blocks(share.size + 1)):
        met, good = positions_on(path.problem, path.segment, np.append(share, 0.5))
        rows, _ = _rows(path, met, good.shape)
        rows[PHASE] -= rows[PHASE, :, -1:].copy()
        table[:, path.cases] = rows[..., :-1]
        known = path.segment.status[:, None]
        code = np.where((known == Status.SOLVED) & ~good, np.int8(Status.NOT_CONVERGED), known)
        status[path.cases] = code[:, :-1]
    return table, status


def rows_at_l1(paths: list[SurfacePaths], l1: FloatArray) -> tuple[FloatArray, Codes]:
    """Return rows (ROW_COUNT, cases, positions) and status at flank parameters `l1` (cases, positions) of the
    pinion, mm.

    Positions outside the limits are OFF_FLANK. PHASE is relative to the middle of the path, or without a path
    to the contact in the middle of the given l1.
    """
    # Distance from a limit up to which a position is on the flanks.
    limit_tolerance_mm = 1e-9
    table, status = np.full((ROW_COUNT, *l1.shape), np.nan), np.full(l1.shape, np.int8(Status.NOT_CONVERGED))
    for path in paths:
        problem, segment, given = path.problem, path.segment, l1[path.cases]
        middle = 0.5 * (given.min(axis=-1, keepdims=True) + given.max(axis=-1, keepdims=True))
        met, good, several = _at_l1(problem, segment, np.concatenate((given, middle), axis=-1))
        rows, margin = _rows(path, met, good.shape)
        met, known = positions_on(problem, segment, np.array((0.5,)))
        phase = _rows(path, met, known.shape)[0][PHASE]
        rows[PHASE] -= np.where(np.isnan(phase), rows[PHASE, :, -1:], phase)
        code = np.where(good, np.int8(Status.SOLVED), np.int8(Status.NOT_CONVERGED))
        code[good & (margin < -limit_tolerance_mm)] = Status.OFF_FLANK
        code[several] = Status.SEVERAL_CONTACTS
        rows[:, several] = np.nan
        rows[0, :, :-1] = given
        code[segment.status == Status.UNDEFINED] = Status.UNDEFINED
        table[:, path.cases], status[path.cases] = rows[..., :-1], code[:, :-1]
    return table, status


def _at_l1(problem: Problem, segment: Segment, l1: FloatArray) -> tuple[Contacts, Mask, Mask]:
    """Return contacts (cases * positions) at given l1 (cases, positions), whether they were solved, and where
    the segment has several contacts with this l1.
    """
    cases, count = l1.shape
    knots = segment.knots
    # Number of times that the segment passes each l1.
    low, high = knots[0, :, None, :-1], knots[0, :, None, 1:]
    passed = ((low - l1[..., None]) * (high - l1[..., None]) < 0.0) | (high == l1[..., None])
    passed &= low != high
    several = passed.sum(axis=-1) > 1
    # Start on the segment, and elsewhere in the middle of the face.
    placed = problem.placed.of_cases(np.repeat(np.arange(cases), count))
    start = meshing_start(problem.surfaces, placed, l1.ravel(), np.zeros(l1.size)).reshape(4, cases, count)
    place = passed.argmax(axis=-1) + 1
    ends = [np.take_along_axis(knots, (place - k)[None], axis=-1) for k in (1, 0)]
    share = (l1 - ends[0][0]) / (ends[1][0] - ends[0][0])
    between = ends[0] + share * (ends[1] - ends[0])
    start = np.where(passed.any(axis=-1) & np.isfinite(between).all(axis=0), between, start)
    met, good = solve(problem.surfaces, placed, start.reshape(4, -1), given_row(0, l1.ravel()))
    return met, good.reshape(cases, count) & ~several, several


def _rows(path: SurfacePaths, met: Contacts, shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return the rows (ROW_COUNT, cases, positions) of contacts (cases * positions) of this shape, and their
    least margins, mm; NaN where the state is not known.
    """
    problem, flat = path.problem, met.state
    placed = problem.placed.of_cases(np.repeat(np.arange(shape[0]), shape[1]))
    margins, _ = margins_at(problem, met)
    rows = np.empty((ROW_COUNT, flat.shape[1]))
    rows[0], rows[1], rows[4], rows[5] = flat[0], flat[3], flat[1], met.z2
    for j, rack in enumerate(path.racks):
        rows[2 + j] = (rows[4 + j] - rack_point(rack, rows[j])[2]) / rack.trace[2]
    rows[6], rows[7] = np.hypot(*met.jets[0].plane[0]), np.hypot(met.point[0], met.point[1])
    # From the fixed frame of the gear to S_f.
    for part, (x, y, z), start in ((POINT, met.point, placed.offset), (NORMAL, -met.normal, 0.0)):
        rows[part] = start - x, placed.sin * z - placed.cos * y, placed.sin * y + placed.cos * z
    rows[ROLL], rows[ROLL + 1] = flat[2], np.arctan2(met.turn[1], met.turn[0]) - met.jets[1].phi
    rows[PHASE] = rows[ROLL + 1] + problem.surfaces.ratio * rows[ROLL]
    rows[:, np.isnan(flat).any(axis=0)] = np.nan
    return rows.reshape(ROW_COUNT, *shape), margins.min(axis=0).reshape(shape)
