"""Series of paths that no single flank parameter describes, followed by their length.

`paths_on_flanks` gives the polynomials over l1 wherever they resolve the path, and those through cells that
hold but one curve near the faces (`cells`, `chains`). For the rest, paths that cross n_x = 0, or beside
which another curve of contact may be near the faces, all curves of contact in the window are traced
(`curve_tracing`), their parts near the flanks fitted by polynomials (`chains`), and the part on the flanks
that covers most roll is the path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..status import Status
from .cells import Box, box_of, vanishing, window_of
from .chains import chains_of, missed, series_along, series_of
from .curve_tracing import Part, Window, curves_of, near_flanks
from .ends import Ends, find_ends, no_ends, rough_window
from .equation import Pairing
from .parallel.clear import clear_of_flanks
from .parallel.nearly import nearly_parallel, series_over_w1
from .parallel.paths import parallel_series
from .path_polynomial import COARSE, FINE, NORMAL, STEEP, WIDTH, PathSeries, by_length, series_over_l1
from .roots import Samples

CASES_PER_BLOCK, NEAR_PER_BLOCK = 1024, 128
"""Sizes at which the arrays of a block stay in the cache; the second on parallel axes, or nearly."""
BEYOND = np.array((0.02, 0.3)).reshape(2, 1, 1)
"""Share of the flank depths by which series over l1 reach beyond root and tip, and l2 is sought there."""
FEW, ROUNDS = 5, (9, 9, 17, 33)
"""Grid lines of each member: where a series over l1 is at hand, and else round by round over the cells left
before."""
ONE_PLACE = 1e-9
"""Share of the size of the pair within which two ends are one."""


@dataclass(frozen=True, eq=False)
class Group:
    """Cases solved alike: their numbers, constants, series and ends."""

    cases: NDArray[np.int_]
    pairing: Pairing
    series: PathSeries
    ends: Ends

    def part(self, index: NDArray[np.int_]) -> Group:
        """Give the group of the cases at the places `index`, which rise."""
        if index.size == self.cases.size:
            return self
        series, ends = self.series.cases(index), self.ends.cases(index)
        return Group(self.cases[index], self.pairing.cases(index), series, ends)

    def of(self, cases: NDArray[np.int_]) -> Group:
        """Give the group under the numbers `cases` of its cases in a greater lot."""
        return replace(self, cases=cases[self.cases])


def _with_ends(cases: NDArray[np.int_], pairing: Pairing, series: PathSeries) -> Group:
    """Give the group of some cases, their constants and series."""
    return Group(cases, pairing, series, find_ends(pairing, series))


def paths_on_flanks(pairing: Pairing) -> list[Group]:
    """Give the path of every case on its flanks; of several the one that covers most roll.

    Series over l1 are made a block of cases at a time. What these leave open is looked for in the cells near
    the faces; the cases that these do not describe are followed together, as a step of a trace costs little
    more for many than for one: near the faces, and all over the window where that leaves a doubt."""
    parallel, near = pairing.parallel, np.flatnonzero(nearly_parallel(pairing))
    if not (near.size or parallel.any()):
        return _crossed(pairing)
    clear = clear_of_flanks(pairing.cases(near))
    off = np.full(np.count_nonzero(clear), np.int8(Status.OFF_FLANK))
    groups = [_without_path(pairing, near[clear], off)]
    for cases, series_of_all in ((np.flatnonzero(parallel), parallel_series), (near[~clear], series_over_w1)):
        for index in _blocks(cases, NEAR_PER_BLOCK):
            part = pairing.cases(index)
            whole = _with_ends(index, part, series_of_all(part))
            # Nearly parallel axes can have a path that w1 does not describe.
            told = (whole.ends.status == Status.SOLVED) | parallel[index]
            groups.append(whole.part(np.flatnonzero(told)))
    groups = [group for group in groups if group.cases.size]
    rest = np.setdiff1d(np.arange(parallel.size), np.concatenate([[], *(group.cases for group in groups)]))
    rest = rest.astype(int)
    return groups + [group.of(rest) for group in (_crossed(pairing.cases(rest)) if rest.size else [])]


def _crossed(pairing: Pairing) -> list[Group]:
    """Find the paths of cases whose axes are not parallel."""
    count = pairing.branch.shape[0]
    groups: list[Group] = []
    told: list[Group] = []
    open_ones = []
    for block in _blocks(np.arange(count)):
        sure, doubted, rest = _over_l1(pairing.cases(block) if block.size < count else pairing)
        groups += [group.of(block) for group in sure]
        told += [group.of(block) for group in doubted]
        open_ones.append(block[rest])
    if not np.concatenate(open_ones).size:
        return groups
    known = np.isin(np.arange(count), np.concatenate([group.cases for group in told]))
    low, high = np.empty((2, 2, count, 1))
    left, again = [], []
    for block in _blocks(np.concatenate(open_ones)):
        found, rest, bounds = _near_faces(pairing.cases(block), known[block])
        groups += [group.of(block) for group in found]
        known[block[np.concatenate([rest, *(group.cases for group in found)])]] = False
        left.append(block[rest])
        low[:, left[-1]], high[:, left[-1]] = bounds
    parts = [group.part(np.flatnonzero(known[group.cases])) for group in told]
    groups += [part for part in parts if part.cases.size]
    for block in _blocks(np.concatenate(left)):
        found = _followed(pairing.cases(block), (low[:, block], high[:, block]))
        kept = [group.part(np.flatnonzero(group.ends.status != Status.NOT_CONVERGED)) for group in found]
        groups += [group.of(block) for group in kept if group.cases.size]
        again.append(np.delete(block, np.concatenate([group.cases for group in kept])))
    for block in _blocks(np.concatenate(again)) if again else ():
        groups += [group.of(block) for group in _followed(pairing.cases(block))]
    return groups


def _blocks(cases: NDArray[np.int_], size: int = CASES_PER_BLOCK) -> list[NDArray[np.int_]]:
    return [cases[start : start + size] for start in range(0, cases.size, size)]


def _over_l1(pairing: Pairing) -> tuple[list[Group], list[Group], NDArray[np.int_]]:
    """Give paths by series over l1: those that are sure, those beside which other curves may be, and the
    cases whose path is not sure, or not found.

    The sign of n_x that the design's pitch point has is not the only one possible, nor does a series say
    what lies beyond its window. Where n_x comes near zero, nothing is found on the flanks, or l1 describes
    but a part of the curve, a few cells mostly say at once that no other is near the faces."""
    spare = BEYOND * (pairing.highest - pairing.lowest)
    series, samples = series_over_l1(pairing, pairing.lowest - spare, pairing.highest + spare, COARSE)
    whole = _with_ends(np.arange(len(series.status)), pairing, series)
    n_x = series.coefficients[NORMAL.start]
    steep = ~(2.0 * np.abs(n_x[:, 0]) - np.abs(n_x).sum(axis=-1) > STEEP)
    lost = (whole.ends.status != Status.SOLVED) | steep
    if not lost.any():
        return [whole], [], np.empty(0, dtype=int)
    told, sure, void = _told(whole), ~lost, np.zeros(len(lost), dtype=bool)
    at = np.flatnonzero(lost)
    part = pairing.cases(at)
    box = box_of(part, *window_of(part), nodes=FEW)
    defined = ~(part.undefined | vanishing(part))
    sure[at], void[at] = (box.none | box.one) & defined, box.none & ~box.missing & defined & ~told[at]
    some = _over_some_of_l1(whole, samples, np.flatnonzero(lost & ~told & ~void))
    empty, off = np.flatnonzero(void), np.full(np.count_nonzero(void), np.int8(Status.OFF_FLANK))
    found = [
        whole.part(np.flatnonzero(told & sure)),
        some.part(np.flatnonzero(sure[some.cases])),
        _without_path(pairing, empty, off),
    ]
    doubted = [whole.part(np.flatnonzero(told & ~sure)), some.part(np.flatnonzero(~sure[some.cases]))]
    lost[np.concatenate([group.cases for group in found])] = False
    return [group for group in found if group.cases.size], doubted, np.flatnonzero(lost)


def _over_some_of_l1(whole: Group, samples: Samples, cases: NDArray[np.int_]) -> Group:
    """Give those of the `cases` whose path a series over less of l1 describes: over what of their contacts,
    which `samples` at the nodes of their series tell roughly, seems to lie on the flanks."""
    pairing, l1 = whole.pairing.cases(cases), (whole.series.middle + whole.series.half * COARSE.nodes)[cases]
    low, high = rough_window(pairing, np.array((l1, samples.cases(cases).one_way().rough())))
    seen = np.flatnonzero(high[0, :, 0] > low[0, :, 0])
    part, low, high = pairing.cases(seen), low[:, seen], high[:, seen]
    series, _ = series_over_l1(part, low, high, FINE, one_curve=True)
    found = _with_ends(cases[seen], part, series)
    return found.part(np.flatnonzero(found.ends.status == Status.SOLVED))


def _near_faces(pairing: Pairing, known: NDArray[np.bool_]) -> tuple[list[Group], NDArray[np.int_], Window]:
    """Give paths where cells of l1 and l2 leave but one curve near the faces for each sign of n_x, or none:
    they shrink from round to round. And the cases left, with bounds in l1 and l2, mm, of all contacts near
    their faces. The cases that are `known` by a series over all l1, of which the cells say no more, are in
    neither."""
    undefined = pairing.undefined
    status = np.where(undefined, np.int8(Status.UNDEFINED), np.int8(Status.OFF_FLANK))
    kept, void = np.zeros(len(known), dtype=bool), vanishing(pairing)
    owner, fits = np.flatnonzero(~undefined & ~void), []
    sheets, (low, high) = pairing.cases(owner), (bound[:, owner] for bound in window_of(pairing))
    done, empty = np.zeros(owner.size, dtype=bool), np.zeros(owner.size, dtype=bool)
    for turn, nodes in enumerate(ROUNDS):
        at = np.flatnonzero(~done)
        if at.size == 0:
            break
        part = sheets.cases(at)
        box = box_of(part, low[:, at], high[:, at], turn == 0, nodes)
        keep = known[owner[at]] & (box.none | box.one)
        kept[owner[at[keep]]] = True
        tried = np.flatnonzero(box.alone & ~box.none & ~keep)
        low[:, at[tried]], high[:, at[tried]] = box.low[:, tried], box.high[:, tried]
        found, off = _through_cells(part.cases(tried), box.cases(tried))
        fits += [group.of(at[tried]) for group in found]
        empty[np.concatenate((at[box.none], at[tried[off]]))] = True
        done |= empty
        done[np.concatenate([at[keep], *(group.cases for group in fits)])] = True
        if turn == 0:
            status[owner[box.missing & ~box.curve]] = Status.NO_COMMON_NORMAL
            twice = np.flatnonzero(~box.alone)  # from here on either sign by itself
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
    kept[np.concatenate([left, *(group.cases for group in groups)])] = True
    rest = np.flatnonzero(~kept)
    if rest.size:
        groups.append(_without_path(pairing, rest, status[rest]))
    return groups, left, (bounds[0][:, left], bounds[1][:, left])


def _through_cells(pairing: Pairing, box: Box) -> tuple[list[Group], NDArray[np.int_]]:
    """Give paths through cells that hold one curve of the pairing's sign of n_x, over l1 where that is
    enough; and the cases in which it clearly misses the flanks."""
    chains = chains_of(pairing, box)
    off = missed(chains) & (chains.count > 0)
    groups, left = [], (chains.count > 0) & ~off
    for over_l1, asked in ((True, box.one), (False, True)):
        names = np.flatnonzero(left & asked)
        if names.size == 0:
            continue
        for found, series in series_of(pairing.cases(names), chains.cases(names), over_l1):
            whole = _with_ends(names[found], pairing.cases(names[found]), series)
            groups.append(whole.part(np.flatnonzero(_told(whole))))
            left[groups[-1].cases] = False
    return groups, np.flatnonzero(off)


def _told(group: Group) -> NDArray[np.bool_]:
    """Say of which cases a series says whether and where they lie on the flanks."""
    said = (group.ends.status == Status.SOLVED) | (group.ends.status == Status.OFF_FLANK)
    return np.asarray(said & (group.series.status == Status.SOLVED))


def _without_path(pairing: Pairing, cases: NDArray[np.int_], status: NDArray[np.int8]) -> Group:
    """Give cases without a path, and why."""
    part, series = pairing.cases(cases), by_length(np.full((WIDTH, cases.size, 2), np.nan), status)
    return Group(cases, part, series, no_ends(status))


def _followed(pairing: Pairing, near: Window | None = None) -> list[Group]:
    """Give paths by length, of curves `near` the faces alone if bounds are given, as in `curves_of`.

    OFF_FLANK and NO_COMMON_NORMAL are said where all curves found were traced to where they leave the
    window; NOT_CONVERGED is a curve lost, or not resolved on the flanks."""
    curves, missing = curves_of(pairing, near)
    lost = [curve for curve in curves if curve.lost]
    status = np.where(missing, np.int8(Status.NO_COMMON_NORMAL), np.int8(Status.OFF_FLANK))
    if near is not None:  # no curve where signs do not rule one out: the lines of the grid may pass it by
        status[:] = Status.NOT_CONVERGED
    status[pairing.undefined] = Status.UNDEFINED
    status[vanishing(pairing)] = Status.NOT_CONVERGED
    status[[curve.case for curve in curves]] = Status.OFF_FLANK
    parts = near_flanks(pairing, [curve for curve in curves if not curve.lost])
    status[[part.case for part in parts if part.endless]] = Status.ENDLESS
    status[[part.case for part in near_flanks(pairing, lost)]] = Status.NOT_CONVERGED
    parts = [part for part in parts if status[part.case] == Status.OFF_FLANK]
    status[[curve.case for curve in lost]] = Status.NOT_CONVERGED
    whose = np.array([part.case for part in parts], dtype=int)
    groups = _best_of(whose, _parts_fitted(pairing, parts) if parts else [], status == Status.NOT_CONVERGED)
    done = np.concatenate([np.empty(0, dtype=int), *(group.cases for group in groups)])
    rest = np.setdiff1d(np.arange(len(status)), done)
    return [*groups, _without_path(pairing, rest, status[rest])] if rest.size else groups


def _parts_fitted(pairing: Pairing, parts: list[Part]) -> list[Group]:
    """Give series and ends of parts of traced curves, by their numbers."""
    pairing = pairing.cases(np.array([part.case for part in parts]))
    return [_with_ends(found, pairing.cases(found), series) for found, series in series_along(pairing, parts)]


def _best_of(case: NDArray[np.int_], fits: list[Group], incomplete: NDArray[np.bool_]) -> list[Group]:
    """Give one path for each case of which parts are fitted: the part that covers most roll. `case` (parts)
    says whose each is. Where a curve of the case was lost (`incomplete`) and no part lies on the flanks, it
    is not said that none does."""
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
    again = _repeated(case, corners, scale)
    span[again], pieces[again] = -1.0, 0
    total, unsure = np.bincount(case, pieces).astype(int), np.bincount(case, doubtful) > 0
    unsure |= (np.bincount(case, span > 0.0) == 0) & incomplete[: len(unsure)]
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


def _repeated(case: NDArray[np.int_], ends: FloatArray, scale: FloatArray) -> NDArray[np.bool_]:
    """Say which parts end where one before them of the same case does: a curve traced twice."""
    same = case[:, None] == case
    for value in ends.T:
        same &= np.abs(value[:, None] - value) < ONE_PLACE * scale
    return np.asarray(np.tril(same, -1).any(axis=1))
