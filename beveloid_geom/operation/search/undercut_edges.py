"""Searches across the edges at which undercut ends a flank.

The clearance has a kink at such an edge, and its minimum may lie on it. A search that ends on the edge from
one side is continued on the other side. If it ends on the edge again, the edge touches. Edge contacts are
reported with the profile coordinate of the flank.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import FloatArray, Integers, Mask
from ...gear.tooth_side import ToothSurface
from ...status import Limit
from ...support.array_records import joined
from .minimum_clearance import LocalMinima, minimum_clearances
from .search_task import Task


def across_edges(task: Task, least: LocalMinima, box: FloatArray) -> tuple[LocalMinima, Integers]:
    """Continue searches across the undercut edges on which they ended.

    Parameters
    ----------
    task : Task
        Tasks of the results (n,).
    least : LocalMinima
        Results (n,) of searches.
    box : ndarray, shape (2,)
        Half-widths of the first trust box along profile and face, mm.

    Returns
    -------
    least : LocalMinima
        The same results, followed by the results of the continued searches.
    origin : ndarray of int
        For each result, the number of the result at which the search began.
    """
    origin = np.arange(least.f.size)
    new = origin
    for _ in range(2):  # a search can cross one edge of each member
        start, places, sides = _beyond(task, least, new)
        if not start.size:
            break
        searched = replace(task.pick(origin[start]), fillet=sides)
        results = minimum_clearances(searched, places, np.repeat(box[:, None], start.size, axis=1), start)
        new = np.arange(origin.size, origin.size + start.size)
        least, origin = joined((least, results)), np.append(origin, origin[start])
    # Report contacts on an edge with the coordinate of the flank, whichever side found them.
    for member, (surface, limit) in enumerate(_edges(task)):
        place = (least.place, least.meeting)[member]
        on = np.flatnonzero(_on_edge(surface, least.limit == limit, place))
        place[0, on] = surface.flank_start(place[1, on])
    return least, origin


def _edges(task: Task) -> tuple[tuple[ToothSurface, Limit], tuple[ToothSurface, Limit]]:
    return (task.pinion, Limit.PINION_ROOT), (task.gear, Limit.GEAR_ROOT)


def _on_edge(surface: ToothSurface, limited: Mask, place: FloatArray) -> Mask:
    """Return whether places (2, n) limited by the root (`limited`, (2, n)) are on an undercut edge and not
    at the bottom land."""
    if surface.crossing is None:
        return np.zeros(place.shape[1], dtype=bool)
    above = place[0] > 0.5 * (surface.bottom + surface.fillet_end(place[1]))
    return np.asarray(limited.any(axis=0) & above)


def _beyond(task: Task, least: LocalMinima, new: Integers) -> tuple[Integers, FloatArray, Mask]:
    """Return the numbers (k,) of the `new` results that ended on an edge, and the places (2, k) and sides
    (2, k) from which searches continue. Results on the edges of both members are returned twice."""
    numbers, places, sides = [], [], []
    for member, (surface, limit) in enumerate(_edges(task)):
        ends = (least.place, least.meeting)[member][:, new]
        ended = new[_on_edge(surface, least.limit[:, new] == limit, ends) & least.converged[new]]
        if not ended.size:
            continue
        place, meeting = least.place[:, ended].copy(), least.meeting[:, ended]
        fillet = np.stack((task.pinion.on_fillet(*place), task.gear.on_fillet(*meeting)))
        fillet[member] = ~fillet[member]
        if member == 0:
            end, start = surface.fillet_end(place[1]), surface.flank_start(place[1])
            place[0] = np.where(fillet[0], end, start)
        numbers.append(ended)
        places.append(place)
        sides.append(fillet)
    if not numbers:
        return new[:0], np.zeros((2, 0)), np.zeros((2, 0), dtype=bool)
    return np.concatenate(numbers), np.concatenate(places, axis=1), np.concatenate(sides, axis=1)
