"""Paths of contact on the flanks, also where no single flank parameter describes them.

`paths_on_flanks` returns the polynomials over l1 where these resolve the path, and series through cells of
(l1, l2) that contain a single curve near the faces (`root_exclusion`, `curve_series`). For the remaining
cases (paths that cross n_x = 0, or with other curves of contact near the faces) all curves of contact in the
window are traced (`curve_tracing`) and their parts near the flanks fitted by polynomials (`curve_series`).
The path is the part on the flanks with the largest range of roll.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..design.model import Design
from ..status import Status
from ..support.chebyshev import basis_of
from ..support.frozen_arrays import cached
from .curves.curve_series import chain_series, chains_of, missed, series_along
from .curves.curve_tracing import CurvePart, Window, curves_of, near_flanks
from .curves.root_exclusion import Box, box_of, vanishing, window_of
from .ends import Ends, find_ends, no_ends, rough_window
from .flank_pair import FlankPair, generated_pairing
from .parallel.no_contact_bound import clear_of_flanks
from .parallel.paths import parallel_series
from .parallel.small_angle_paths import NEARLY_PARALLEL_SINE, nearly_parallel, series_over_w1
from .path_polynomial import FULL_ROW_COUNT, NORMAL, SMALL_NORMAL_X, PathSeries, not_over_l1, series_over_l1
from .root_samples import RootSamples


@dataclass(frozen=True, eq=False)
class Group:
    """Cases with the same type of solution: their numbers, constants, series and ends."""

    cases: Integers
    pairing: FlankPair
    series: PathSeries
    ends: Ends

    def part(self, index: Integers) -> Group:
        """Return the group of the cases at the positions `index`, in ascending order."""
        if index.size == self.cases.size:
            return self
        series, ends = self.series.cases(index), self.ends.cases(index)
        return Group(self.cases[index], self.pairing.cases(index), series, ends)

    def renumbered(self, cases: Integers) -> Group:
        """Return the group with case k replaced by `cases[k]`, its number in a larger set."""
        return replace(self, cases=cases[self.cases])


def _with_ends(cases: Integers, pairing: FlankPair, series: PathSeries) -> Group:
    """Return the group of cases with their constants and series."""
    return Group(cases, pairing, series, find_ends(pairing, series))


def generated_paths(design: Design, flank: str, undercut: bool = True) -> list[Group]:
    """Return `paths_on_flanks` of the generated flanks; the paths of single designs are cached."""
    find = _generated_paths if design.batch_shape else _cached_paths
    return find(design, flank, undercut)


def _generated_paths(design: Design, flank: str, undercut: bool) -> list[Group]:
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return paths_on_flanks(generated_pairing(design, flank, undercut))


_cached_paths = cached(16)(_generated_paths)


def paths_on_flanks(pairing: FlankPair) -> list[Group]:
    """Return the path of every case on its flanks; of several segments the one with the largest range of
    roll.

    Series over l1 are computed in blocks of cases. Undecided cases are searched in the cells near the faces.
    Cases that these do not describe are traced together, since a step costs little more for many cases than
    for one: first near the faces, then over the entire window where this leaves a doubt.
    """
    if (np.abs(pairing.layout.sin_angle) > NEARLY_PARALLEL_SINE).all():
        return _crossed(pairing)
    parallel, near = pairing.parallel, np.flatnonzero(nearly_parallel(pairing))
    if not (near.size or parallel.any()):
        return _crossed(pairing)
    # Exclude nearly parallel cases without contact, then use series over w1 and the parallel solution.
    clear = clear_of_flanks(pairing.cases(near)) if near.size else np.zeros(0, dtype=bool)
    off = np.full(np.count_nonzero(clear), np.int8(Status.OFF_FLANK))
    groups = [_without_path(pairing, near[clear], off)]
    # Block size for which the arrays stay in the cache, for parallel and nearly parallel axes.
    for cases, series_of_all in ((np.flatnonzero(parallel), parallel_series), (near[~clear], series_over_w1)):
        for index in _blocks(cases, 128):
            part = pairing.cases(index)
            full = _with_ends(index, part, series_of_all(part))
            # On nearly parallel axes a path can exist that w1 does not describe.
            decided = (full.ends.status == Status.SOLVED) | parallel[index]
            groups.append(full.part(np.flatnonzero(decided)))
    groups = [group for group in groups if group.cases.size]
    done = np.concatenate([np.empty(0, dtype=int), *(group.cases for group in groups)])
    remaining = np.setdiff1d(np.arange(parallel.size), done)
    if remaining.size:
        groups += [group.renumbered(remaining) for group in _crossed(pairing.cases(remaining))]
    return groups


def _crossed(pairing: FlankPair) -> list[Group]:
    """Return the paths of cases whose axes are not parallel."""
    count = pairing.branch.shape[0]
    groups: list[Group] = []
    decided: list[Group] = []
    open_ones = []
    # Step 1: series over l1.
    for block in _blocks(np.arange(count)):
        certain, doubtful, remaining = _over_l1(pairing.cases(block) if block.size < count else pairing)
        groups += [group.renumbered(block) for group in certain]
        decided += [group.renumbered(block) for group in doubtful]
        open_ones.append(block[remaining])
    if not any(block.size for block in open_ones):
        return groups
    known = np.isin(np.arange(count), np.concatenate([group.cases for group in decided]))
    low, high = np.empty((2, 2, count, 1))
    left, again = [], []
    # Step 2: cells near the faces.
    for block in _blocks(np.concatenate(open_ones)):
        result, remaining, bounds = _near_faces(pairing.cases(block), known[block])
        groups += [group.renumbered(block) for group in result]
        known[block[np.concatenate([remaining, *(group.cases for group in result)])]] = False
        left.append(block[remaining])
        low[:, left[-1]], high[:, left[-1]] = bounds
    parts = [group.part(np.flatnonzero(known[group.cases])) for group in decided]
    groups += [part for part in parts if part.cases.size]
    # Step 3: trace the curves near the faces, and in the entire window where this fails.
    for block in _blocks(np.concatenate(left)):
        result = _followed(pairing.cases(block), (low[:, block], high[:, block]))
        closed = [group.part(np.flatnonzero(group.ends.status != Status.NOT_CONVERGED)) for group in result]
        groups += [group.renumbered(block) for group in closed if group.cases.size]
        again.append(np.delete(block, np.concatenate([group.cases for group in closed])))
    for block in _blocks(np.concatenate(again)) if again else ():
        groups += [group.renumbered(block) for group in _followed(pairing.cases(block))]
    return groups


def _blocks(cases: Integers, size: int = 1024) -> list[Integers]:
    """Return the cases in blocks whose arrays stay in the cache."""
    return [cases[start : start + size] for start in range(0, cases.size, size)]


def _over_l1(pairing: FlankPair) -> tuple[list[Group], list[Group], Integers]:
    """Return paths by series over l1: certain ones, those with possible other curves nearby, and the cases
    whose path is not certain or was not found.

    The sign of n_x at the pitch point of the design is not the only possible one, and a series does not cover
    the region outside its window. If n_x is nearly zero, if nothing is found on the flanks, or if l1
    describes only a part of the curve, a few cells usually show that no other curve is near the faces.
    """
    # Fractions of the flank depths by which the window reaches beyond root and tip: 0.02 in l1, 0.3 in l2.
    spare = np.array([[[0.02]], [[0.3]]]) * (pairing.highest - pairing.lowest)
    series, samples = series_over_l1(pairing, pairing.lowest - spare, pairing.highest + spare, basis_of(16))
    full = _with_ends(np.arange(len(series.status)), pairing, series)
    n_x = series.coefficients[NORMAL.start]
    # Small n_x within the window: another curve may be near.
    steep = ~(2.0 * np.abs(n_x[:, 0]) - np.abs(n_x).sum(axis=-1) > SMALL_NORMAL_X)
    lost = full.ends.status.astype(bool) | steep
    if not lost.any():
        return [full], [], np.empty(0, dtype=int)
    decided, certain, void = _is_decided(full), ~lost, np.zeros(len(lost), dtype=bool)
    at = np.flatnonzero(lost)
    part = pairing.cases(at)
    # A coarse grid, five lines of each member, for the cases whose series over l1 is not certain.
    box = box_of(part, *window_of(part), nodes=5)
    defined = ~(part.undefined | vanishing(part))
    certain[at], void[at] = (box.none | box.one) & defined, box.none & ~box.missing & defined & ~decided[at]
    partial = _over_part_of_l1(full, samples, np.flatnonzero(lost & ~decided & ~void))
    empty, off = np.flatnonzero(void), np.full(np.count_nonzero(void), np.int8(Status.OFF_FLANK))
    result = [
        full.part(np.flatnonzero(decided & certain)),
        partial.part(np.flatnonzero(certain[partial.cases])),
        _without_path(pairing, empty, off),
    ]
    doubtful = [
        full.part(np.flatnonzero(decided & ~certain)),
        partial.part(np.flatnonzero(~certain[partial.cases])),
    ]
    lost[np.concatenate([group.cases for group in result])] = False
    return [group for group in result if group.cases.size], doubtful, np.flatnonzero(lost)


def _over_part_of_l1(full: Group, samples: RootSamples, cases: Integers) -> Group:
    """Return those of the `cases` whose path is described by a series over a part of l1: the part in which
    their contacts, known approximately from `samples` at the nodes of their series, seem to be on the flanks.
    """
    pairing, series = full.pairing.cases(cases), full.series.cases(cases)
    l1 = series.middle + series.half * basis_of(16).nodes
    low, high = rough_window(pairing, np.array((l1, samples.cases(cases).of_main_direction().rough())))
    seen = np.flatnonzero(high[0, :, 0] > low[0, :, 0])
    part, low, high = pairing.cases(seen), low[:, seen], high[:, seen]
    series, _ = series_over_l1(part, low, high, basis_of(20), one_curve=True)
    result = _with_ends(cases[seen], part, series)
    return result.part(np.flatnonzero(result.ends.status == Status.SOLVED))


def _near_faces(pairing: FlankPair, known: Mask) -> tuple[list[Group], Integers, Window]:
    """Return paths where the cells of l1 and l2 leave at most one curve near the faces for each sign of n_x.

    The cells shrink from round to round. The other results are the remaining cases, and bounds in l1 and l2,
    mm, of all contacts near their faces. Cases that are `known` from a series over l1 or a part of it, and
    whose cells show no other curve, are in neither list: they keep this series.
    """
    undefined = pairing.undefined
    status = np.where(undefined, np.int8(Status.UNDEFINED), np.int8(Status.OFF_FLANK))
    closed, void = np.zeros(len(known), dtype=bool), vanishing(pairing)
    owner, fits = np.flatnonzero(~undefined & ~void), []
    sheets, (low, high) = pairing.cases(owner), (bound[:, owner] for bound in window_of(pairing))
    done, empty = np.zeros(owner.size, dtype=bool), np.zeros(owner.size, dtype=bool)
    # Refine the grid from round to round: grid lines of each member over the cells that remain.
    for turn, nodes in enumerate((9, 9, 17, 33)):
        at = np.flatnonzero(~done)
        if at.size == 0:
            break
        part = sheets.cases(at)
        box = box_of(part, low[:, at], high[:, at], turn == 0, nodes)
        keep = known[owner[at]] & (box.none | box.one)
        closed[owner[at[keep]]] = True
        tried = np.flatnonzero(box.alone & ~box.none & ~keep)
        low[:, at[tried]], high[:, at[tried]] = box.low[:, tried], box.high[:, tried]
        result, off = _through_cells(part.cases(tried), box.cases(tried))
        fits += [group.renumbered(at[tried]) for group in result]
        empty[np.concatenate((at[box.none], at[tried[off]]))] = True
        done |= empty
        done[np.concatenate([at[keep], *(group.cases for group in fits)])] = True
        # After the first round, both signs of n_x are treated as separate cases.
        if turn == 0:
            status[owner[box.missing & ~box.curve]] = Status.NO_COMMON_NORMAL
            twice = np.flatnonzero(~box.alone)  # from here on, both signs are treated separately
            known = known & ~np.isin(np.arange(len(known)), owner[twice])
            other = sheets.cases(twice)
            sheets = sheets.cases(np.append(np.arange(owner.size), twice))
            sheets.branch[owner.size :] = -other.branch
            owner, done, empty = (np.append(x, x[twice]) for x in (owner, done, empty))
            low, high = (np.concatenate((x, x[:, twice]), axis=1) for x in (low, high))
    left = np.append(np.unique(owner[~done]), np.flatnonzero(void & ~undefined))
    bounds, sought = np.array(window_of(pairing)), ~empty & np.isin(owner, left)
    bounds[:, :, owner[sought]] = np.array((np.inf, -np.inf)).reshape(2, 1, 1, 1)
    for member in range(2):
        np.minimum.at(bounds[0, member], owner[sought], low[member, sought])
        np.maximum.at(bounds[1, member], owner[sought], high[member, sought])
    fits = [group.part(np.flatnonzero(~np.isin(owner[group.cases], left))) for group in fits]
    groups = _best_of(owner, fits, np.zeros(len(known), dtype=bool))
    closed[np.concatenate([left, *(group.cases for group in groups)])] = True
    remaining = np.flatnonzero(~closed)
    if remaining.size:
        groups.append(_without_path(pairing, remaining, status[remaining]))
    return groups, left, (bounds[0][:, left], bounds[1][:, left])


def _through_cells(pairing: FlankPair, box: Box) -> tuple[list[Group], Integers]:
    """Return paths through cells with one curve of the sign of n_x of the pair, over l1 if this is
    sufficient; and the cases in which the curve clearly misses the flanks.
    """
    chains = chains_of(pairing, box)
    off = missed(chains) & (chains.count > 0)
    groups, left = [], (chains.count > 0) & ~off
    for over_l1, asked in ((True, box.one), (False, True)):
        names = np.flatnonzero(left & asked)
        if names.size == 0:
            continue
        for result, series in chain_series(pairing.cases(names), chains.cases(names), over_l1):
            full = _with_ends(names[result], pairing.cases(names[result]), series)
            groups.append(full.part(np.flatnonzero(_is_decided(full))))
            left[groups[-1].cases] = False
    return groups, np.flatnonzero(off)


def _is_decided(group: Group) -> Mask:
    """Return for which cases a series decides whether and where they are on the flanks."""
    known = (group.ends.status == Status.SOLVED) | (group.ends.status == Status.OFF_FLANK)
    return np.asarray(known & (group.series.status == Status.SOLVED))


def _without_path(pairing: FlankPair, cases: Integers, status: Codes) -> Group:
    """Return cases without a path, with the reason."""
    part, series = pairing.cases(cases), not_over_l1(np.full((FULL_ROW_COUNT, cases.size, 2), np.nan), status)
    return Group(cases, part, series, no_ends(status))


def _followed(pairing: FlankPair, near: Window | None = None) -> list[Group]:
    """Return paths from traced curves; only from those `near` the faces if bounds are given (`curves_of`).

    OFF_FLANK and NO_COMMON_NORMAL mean that all curves found were traced until they left the window.
    NOT_CONVERGED means that a curve was lost, or not resolved on the flanks.
    """
    curves, missing = curves_of(pairing, near)
    lost = [curve for curve in curves if curve.lost]
    status = np.where(missing, np.int8(Status.NO_COMMON_NORMAL), np.int8(Status.OFF_FLANK))
    if near is not None:  # the grid lines may miss a curve in cells where the signs do not exclude one
        status[:] = Status.NOT_CONVERGED
    status[pairing.undefined] = Status.UNDEFINED
    status[vanishing(pairing)] = Status.NOT_CONVERGED
    status[[curve.case for curve in curves]] = Status.OFF_FLANK
    # Paths that close on the flanks, and lost curves, are not fitted.
    parts = near_flanks(pairing, [curve for curve in curves if not curve.lost])
    status[[part.case for part in parts if part.endless]] = Status.ENDLESS
    status[[part.case for part in near_flanks(pairing, lost)]] = Status.NOT_CONVERGED
    parts = [part for part in parts if status[part.case] == Status.OFF_FLANK]
    status[[curve.case for curve in lost]] = Status.NOT_CONVERGED
    whose = np.array([part.case for part in parts], dtype=int)
    groups = _best_of(whose, _parts_fitted(pairing, parts) if parts else [], status == Status.NOT_CONVERGED)
    done = np.concatenate([np.empty(0, dtype=int), *(group.cases for group in groups)])
    remaining = np.setdiff1d(np.arange(len(status)), done)
    return [*groups, _without_path(pairing, remaining, status[remaining])] if remaining.size else groups


def _parts_fitted(pairing: FlankPair, parts: list[CurvePart]) -> list[Group]:
    """Return series and ends of parts of traced curves, by their numbers."""
    pairing = pairing.cases(np.array([part.case for part in parts]))
    return [
        _with_ends(result, pairing.cases(result), series) for result, series in series_along(pairing, parts)
    ]


def _best_of(case: Integers, fits: list[Group], incomplete: Mask) -> list[Group]:
    """Return one path for each case with fitted parts: the part with the largest range of roll.

    `case` (parts) is the case of each part. If a curve of the case was lost (`incomplete`) and no part is on
    the flanks, the result is not OFF_FLANK.
    """
    fits = [fit for fit in fits if fit.cases.size]
    if not fits:
        return []
    names, places = np.unique(np.concatenate([fit.cases for fit in fits]), return_inverse=True)
    case, cuts = case[names], np.cumsum([fit.cases.size for fit in fits])[:-1]
    fits = [replace(fit, cases=place) for fit, place in zip(fits, np.split(places, cuts), strict=True)]
    span, pieces = np.full(case.size, -1.0), np.zeros(case.size, dtype=int)
    doubtful, corners, scale = np.zeros(case.size, dtype=bool), np.full((case.size, 4), np.nan), span.copy()
    for fit in fits:
        state = fit.ends.status
        span[fit.cases] = np.where(state == Status.SOLVED, fit.ends.span, -1.0)
        pieces[fit.cases] = fit.ends.pieces
        doubtful[fit.cases] = (state != Status.SOLVED) & (state != Status.OFF_FLANK)
        corners[fit.cases] = np.concatenate(tuple(fit.ends.l), axis=-1)
        scale[fit.cases] = fit.pairing.scale[:, 0]
    # A part traced twice counts once.
    again = _repeated(case, corners, scale)
    span[again], pieces[again] = -1.0, 0
    total, unsure = np.bincount(case, pieces).astype(int), np.bincount(case, doubtful) > 0
    unsure |= (np.bincount(case, span > 0.0) == 0) & incomplete[: len(unsure)]
    # The part with the largest range of roll of each case.
    order = np.lexsort((-span, case))
    best = order[np.unique(case[order], return_index=True)[1]]
    groups = []
    for fit in fits:
        chosen = np.flatnonzero(np.isin(fit.cases, best))
        if chosen.size == 0:
            continue
        fit = fit.part(chosen)
        owner = case[fit.cases]
        if unsure[owner].any():
            fit.series.status[unsure[owner]] = Status.NOT_CONVERGED
            fit = replace(fit, ends=find_ends(fit.pairing, fit.series))
        counted = np.where(fit.ends.status == Status.SOLVED, total[owner], 0)
        groups.append(replace(fit, cases=owner, ends=replace(fit.ends, pieces=counted)))
    return groups


def _repeated(case: Integers, ends: FloatArray, scale: FloatArray) -> Mask:
    """Return which parts have the same ends as an earlier part of the same case: a curve traced twice."""
    # Distance of two ends, relative to the size of the pair, below which they are the same.
    same_end_tolerance = 1e-9
    same = case[:, None] == case
    for value in ends.T:
        same &= np.abs(value[:, None] - value) < same_end_tolerance * scale
    return np.asarray(np.tril(same, -1).any(axis=1))
