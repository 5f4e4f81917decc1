"""Local minima of the clearance within the limits of both members.

From each start, sequential quadratic programming minimises f(s1, z1) subject to c(s1, z1) >= 0
(`local_clearance`): each step minimises the quadratic model of the Lagrange function within the linearised
limits and a trust box (`support.qp2`). The limits that are active in the last step are the edges of the
contact."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import Codes, FloatArray, Integers, Mask
from ...status import Limit
from ...support.array_records import joined
from ...support.qp2 import quadratic_step
from .local_clearance import Local, local_at
from .search_task import Task

BOX_SIDES = np.array(((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)))[..., None]
ON_LIMIT_DEPTHS = 1e-10
"""Tooth depths by which a result may violate a limit."""
F_NOISE_DEPTHS = 1e-12
"""Tooth depths below which changes of f are rounding."""


@dataclass(frozen=True, eq=False)
class LocalMinima:
    """Local minima of the clearance, mm.

    Attributes
    ----------
    place, meeting : ndarray, shape (2, n)
        s1 and z1 on the pinion, s2 and z2 on the gear.
    f, outside : ndarray, shape (n,)
        Clearance, and largest violation of a limit.
    limit : ndarray of int, shape (2, n)
        Codes of the active limits, -1 for none.
    converged : ndarray of bool, shape (n,)
    """

    place: FloatArray
    f: FloatArray
    meeting: FloatArray
    limit: Codes
    outside: FloatArray
    converged: Mask

    def pick(self, index: Integers) -> LocalMinima:
        """Return the results `index`."""
        return LocalMinima(*(value.take(index, axis=-1) for value in vars(self).values()))


def minimum_clearances(task: Task, place: FloatArray, box: FloatArray, owner: Integers) -> LocalMinima:
    """Search the local minimum of the clearance from each start.

    Parameters
    ----------
    task : Task
        Of the searches (n,).
    place : ndarray, shape (2, n)
        Starts (s1, z1), mm.
    box : ndarray, shape (2, n)
        Half-widths of the first trust box, mm. On a fillet, where f is concave, also the limit of all later
        steps along the profile.
    owner : ndarray of int, shape (n,)
        If searches with the same owner reach the same place, only one is continued. The others end with
        infinite `outside`.

    Returns
    -------
    LocalMinima
        One result for each start.
    """
    # Searches solved together; duplicates are detected within one block only.
    searches_per_block = 8192
    parts = []
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        every = np.arange(place.shape[1])
        for start in range(0, max(1, every.size), searches_per_block):
            block = every[start : start + searches_per_block]
            parts.append(_least(task.pick(block), place[:, block], box[:, block], owner[block]))
    return joined(parts)


def _least(task: Task, place: FloatArray, box: FloatArray, owner: Integers) -> LocalMinima:
    """Return the minima of one block of searches."""
    n, depth = place.shape[1], task.depth
    here = local_at(task, *place)
    least = LocalMinima(
        place=place.copy(),
        f=here.f.copy(),
        meeting=here.meeting.copy(),
        limit=np.full((2, n), -1, dtype=np.int8),
        outside=np.maximum(-here.margin.min(axis=0), 0.0),
        converged=np.zeros(n, dtype=bool),
    )
    going = np.flatnonzero(np.isfinite(here.f))
    if going.size < n:
        task, place, box, here = task.pick(going), place[:, going], box[:, going], here.pick(going)
    weight, reach = np.zeros((len(Limit), going.size)), np.ones(going.size)
    unit = 1e-3 * box.max(axis=1, initial=0.0, keepdims=True)  # places closer than this are equal
    # Maximum number of steps, and number after which a step without change of f ends the search.
    max_steps, constant_f_steps = 60, 20
    # Tooth depths below which a step is the last; the remaining error is of the order of its square.
    last_step_depths = 1e-7
    for count in range(max_steps):
        if not going.size:
            break
        step, active, pull = _newton_steps(here, weight, reach, box, depth)
        boxed = (active >= len(Limit)).any(axis=0)
        there = local_at(task, *(place + step))
        better = _accepted(here, there, pull, depth)
        small = (np.abs(step) <= last_step_depths * depth).all(axis=0) & ~boxed
        if count >= constant_f_steps:  # on a line of constant f, steps need not become small
            small |= (np.abs(there.f - here.f) <= F_NOISE_DEPTHS * depth) & ~boxed
        if better.all():
            place, here, weight = place + step, there, pull
        else:
            place, weight = np.where(better, place + step, place), np.where(better, pull, weight)
            here = here.where_not(better, there)
        # Double the box after an accepted step that ended on it, quarter it after a rejected one.
        reach = reach * np.where(better, np.where(boxed, 2.0, 1.0), 0.25)
        solved, doubled = small & better, np.zeros(going.size, dtype=bool)
        if count:  # stop searches that reach the place of another search, active or ended
            near = np.flatnonzero(better & ~boxed & ~solved)
            doubled[near] = _reached_by_others(
                least, place[:, near] / unit, unit, active[:, near], owner, going[near]
            )
        done = solved | doubled | (reach <= 1e-12) | (count == max_steps - 1)
        if not done.any():
            continue
        ended, stays = going[done], np.flatnonzero(~done)
        least.place[:, ended], least.f[ended], least.meeting[:, ended] = (
            row[..., done] for row in (place, here.f, here.meeting)
        )
        least.limit[:, ended], least.converged[ended] = active[:, done], solved[done]
        least.outside[ended] = np.where(doubled, np.inf, np.maximum(-here.margin.min(axis=0), 0.0))[done]
        task, here, going, reach = task.pick(stays), here.pick(stays), going[stays], reach[stays]
        place, box, weight = (rows.take(stays, axis=1) for rows in (place, box, weight))
    limit = np.sort(np.where(least.limit >= len(Limit), -1, least.limit), axis=0)[::-1]
    return replace(least, limit=limit)


def _newton_steps(
    here: Local, weight: FloatArray, reach: FloatArray, box: FloatArray, depth: float
) -> tuple[FloatArray, Integers, FloatArray]:
    """Return the steps (2, n) to the minima of quadratic models within limits and trust box, the active
    limits (2, n), and the multipliers of the limits of the flanks.

    `weight` are the multipliers of the step before, `reach` (n,) the sizes of the boxes in units of `box`."""
    # The box grows along the profile only where f is convex, that is, off the fillets.
    size = np.array((np.where(here.bend[0] > 0.0, reach, np.minimum(reach, 1.0)), reach)) * box
    lines = np.concatenate((here.rate, BOX_SIDES.repeat(reach.size, axis=2)))
    margin = np.concatenate((here.margin, size, size))
    bend = here.bend - (weight[:, None] * here.curve).sum(axis=0)
    step, active, multiplier = quadratic_step(here.slope, bend, lines, margin, size, ON_LIMIT_DEPTHS * depth)
    return step, active, np.maximum(multiplier[: len(Limit)], 0.0)


def _accepted(here: Local, there: Local, pull: FloatArray, depth: float) -> Mask:
    """Return which steps from `here` to `there` decrease the merit function with the multipliers `pull`."""
    better = there.merit(pull, depth) <= here.merit(pull, depth) + F_NOISE_DEPTHS * depth
    # On a fillet f is concave, and the multipliers at the end of a step can hide that f decreases: accept
    # a smaller f within the limits.
    within = np.minimum(here.margin, there.margin).min(axis=0) >= -ON_LIMIT_DEPTHS * depth
    return np.asarray(better | (within & (there.f < here.f - F_NOISE_DEPTHS * depth)))


def _reached_by_others(
    least: LocalMinima,
    places: FloatArray,
    unit: FloatArray,
    active: Integers,
    owner: Integers,
    number: Integers,
) -> Mask:
    """Return which searches `number` (n,) are at the place of another search of their owner, active or
    converged. `places` (2, n) are in the `unit` (2, 1) within which places are equal."""
    met = np.flatnonzero(least.converged)
    every = np.concatenate((least.place[:, met] / unit, places), axis=1)
    limits = np.concatenate((least.limit[:, met], active), axis=1)
    owners = owner[np.append(met, number)]
    return repeated(np.array((*np.rint(every), *limits, owners)))[met.size :]


def repeated(columns: FloatArray) -> Mask:
    """Return which columns are equal to an earlier one.

    Parameters
    ----------
    columns : ndarray, shape (k, n)

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    order = np.lexsort(columns)
    doubled = np.zeros(order.size, dtype=bool)
    doubled[order[1:]] = (columns[:, order[1:]] == columns[:, order[:-1]]).all(axis=0)
    return doubled
