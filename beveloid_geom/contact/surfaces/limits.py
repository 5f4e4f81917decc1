"""Limits of both flanks at contacts of `tangency`, with derivatives, the pair as `tangency` needs it, and
conditions that select a point of a curve of contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FloatArray, Integers
from ...gear.crossing_curve import START, CrossingCurve
from ...status import Limit
from .tangency import Condition, Contacts, PairPlacement, Surfaces


@dataclass(frozen=True, eq=False)
class Problem:
    """Flank pairs of the same two members in different placements.

    `placed` has one entry per case. `lowest`, `highest`, `tip`, `half_width` (2,), mm, and `taper` (2,) are
    the limits as in `FlankPair`; `edges` (2) are the curves on which undercut ends the flanks, or None.
    `generated_lines`: whether the flanks would touch along lines without their modifications; the roll then
    seldom turns back along a path. `line_contact`: whether they also touch along lines with their
    modifications; the pinion then has the additional helix crowning of LINE_CROWNING_MODULES.
    """

    surfaces: Surfaces
    placed: PairPlacement
    lowest: FloatArray
    highest: FloatArray
    tip: FloatArray
    taper: FloatArray
    half_width: FloatArray
    edges: tuple[CrossingCurve | None, ...]
    line_contact: bool = False
    generated_lines: bool = False

    @property
    def scale(self) -> FloatArray:
        """Flank depth and face width of the pinion (mm) and pitch (rad), (3,)."""
        return self.surfaces.largest

    def cases(self, index: Integers) -> Problem:
        """Return the problem of the cases `index`."""
        fields: dict[str, Any] = {**vars(self), "placed": self.placed.take(index)}
        return Problem(**fields)


def margins_at(problem: Problem, met: Contacts) -> tuple[FloatArray, FloatArray]:
    """Return distances (8, n), mm, from the limits in the order of `Limit`, and their derivatives (8, 3, n).

    The derivatives are by s1, z1 and the roll; s2 follows at equal radius.
    """
    s, z = (met.state[0], met.state[3]), (met.state[1], met.z2)
    pinion_plane, gear_point = met.jets[0].plane, met.point
    radii = np.sqrt(pinion_plane[0, 0] ** 2 + pinion_plane[0, 1] ** 2), np.hypot(gear_point[0], gear_point[1])
    zero, one = np.zeros_like(z[0]), np.ones_like(z[0])
    s_by = np.array((one, zero, zero)), met.follow[1:]
    z_by = np.array((zero, one, zero)), met.moves[2]
    pinion_r_by = (pinion_plane[0] * pinion_plane[1:3]).sum(axis=1) / radii[0]
    r_by = (
        np.array((*pinion_r_by, zero)),
        (gear_point[0] * met.moves[0] + gear_point[1] * met.moves[1]) / radii[1],
    )
    values, rates = np.empty((8, s[0].size)), np.empty((8, 3, s[0].size))
    for j, edge in enumerate(problem.edges):
        root, tip, toe, heel = (limit + j for limit in range(0, len(Limit), 2))
        values[root], rates[root] = s[j] - problem.lowest[j], s_by[j]
        if edge is not None:
            start, slope = edge.rows(z[j])[START, :2]
            nearer = s[j] - start < values[root]
            values[root] = np.where(nearer, s[j] - start, values[root])
            rates[root] = np.where(nearer, s_by[j] - slope * z_by[j], rates[root])
        values[tip] = problem.tip[j] + problem.taper[j] * z[j] - radii[j]
        rates[tip] = problem.taper[j] * z_by[j] - r_by[j]
        values[toe], rates[toe] = problem.half_width[j] + z[j], z_by[j]
        values[heel], rates[heel] = problem.half_width[j] - z[j], -z_by[j]
    return values, rates


def least_margin(problem: Problem, met: Contacts) -> tuple[FloatArray, FloatArray, Integers]:
    """Return the least margin (n,), mm, its derivatives (3, n) and its limit (n,)."""
    values, rates = margins_at(problem, met)
    limit, index = values.argmin(axis=0), np.arange(values.shape[1])
    return values[limit, index], rates[limit, :, index].T, limit


def least_limit(problem: Problem) -> Condition:
    """Return the condition that the least margin vanishes."""

    def condition(met: Contacts, index: Integers) -> tuple[FloatArray, FloatArray]:
        value, rate, _ = least_margin(problem, met)
        return value, rate

    return condition


def on_plane(problem: Problem, state: FloatArray, direction: FloatArray) -> Condition:
    """Return the condition that contacts are in planes through states (4, n), perpendicular to directions
    (3, n) in the units of `Problem.scale`.
    """
    normal = direction / problem.scale[:, None]

    def condition(met: Contacts, index: Integers) -> tuple[FloatArray, FloatArray]:
        away = (met.state[:3] - state[:3, index]) / problem.scale[:, None]
        return (away * direction[:, index]).sum(axis=0), normal[:, index]

    return condition
