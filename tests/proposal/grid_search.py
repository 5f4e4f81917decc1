"""Requests solved by an independent search.

It shares neither starts, unknowns nor rounded values with `proposal`. Points are spread evenly over all cone
angles, helix angles and shifts within the limits, moved by the shortest steps to pairs that meet the request,
and checked as by `check`.
"""

from __future__ import annotations

from math import radians

import numpy as np
from scipy.stats import qmc

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.findings.advice import design_remarks
from beveloid_geom.findings.backlash import backlash_report
from beveloid_geom.findings.diagnostics import quiet
from beveloid_geom.pair.generator_angle import closed_normal, generator_angle_as_mounted
from beveloid_geom.pair.zero_backlash import layout_deviation
from beveloid_geom.proposal.closure_equations import pair_at
from beveloid_geom.proposal.merit import criteria_of, design_of, tooth_criteria
from beveloid_geom.proposal.request import Request

POINTS, SEED = 2**10, 15
"""Number of points (a power of two) and seed of the Sobol sequence."""
SCALE = np.array([0.05, 0.05, 0.2, 0.2, 0.4, 0.4, 0.05])
"""Scales of cone angles, helix angles, shifts and pressure angle in the length of a step."""
MAX_ITERATIONS, DIFFERENCE_STEP, TOLERANCE = 40, 1e-7, 1e-11
MAX_CHECKS = 12
"""Number of pairs that are checked completely, those with the largest reserve."""


def pairs_on_grid(request: Request, points: int = POINTS) -> FloatArray:
    """Return pairs (7, n) within the limits that meet the request."""
    limits = (request.cone_limits,) * 2 + (request.helix_limits,) * 2 + (request.shift_limits,) * 2
    low, high = np.array(limits).T[..., None]
    spread = qmc.Sobol(8, seed=SEED).random(points).T
    values = np.vstack((low + (high - low) * spread[:6], np.full((1, points), request.pressure_angle + 0.01)))
    free = np.ones(7, bool)
    for rows, given in (
        ((0, 1), request.cone_angles),
        ((2,), None if request.helix_angle is None else (request.helix_angle,)),
        ((4, 5), request.shifts),
        ((1, 3, 5), request.gear and [float(getattr(request.gear, n)) for n in MEMBER_FIELDS]),
    ):
        if given is not None:
            values[list(rows)], free[list(rows)] = np.array(given)[:, None], False
    signs = np.where(spread[6:] < 0.5, -1.0, 1.0)
    values, met = _moved(request, values, signs, free)
    if request.offset is None:  # the sense of the shaft angle is that of the helix angles
        met &= pair_at(request.members, values)[1].offset > 0.0
    inside = ((values[:6] > low - 1e-9) & (values[:6] < high + 1e-9)) | ~free[:6, None]
    return values[:, met & inside.all(axis=0)]


MEMBER_FIELDS = ("cone_angle", "helix_angle", "profile_shift")


def _misses(request: Request, values: FloatArray, signs: FloatArray) -> FloatArray:
    design, layout = pair_at(request.members, values)
    if request.shaft_angle == 0.0:  # two equations: both angles cancel
        misses = [layout.cone_angle.sum(axis=0), layout.helix_angle.sum(axis=0)]
        distance = layout.working_radius.sum(axis=0)
    else:
        misses = [layout.shaft_angle - request.shaft_angle]
        distance = signs[0] * design.sense * layout.offset
    misses.append((layout.normal_backlash - request.backlash) / request.module)
    if request.offset is not None:
        misses.append((distance - request.offset) / request.module)
    if request.crossing is not None and request.shaft_angle > 0.0:
        angle = closed_normal(layout, request.flank, signs[0])[1]
        misses.append(angle - signs[1] * request.crossing)
    return np.stack(misses)


def _moved(request: Request, values: FloatArray, signs: FloatArray, free: Mask) -> tuple[FloatArray, Mask]:
    """Return pairs after shortest steps towards all equations at once, limited to SCALE, and the mask of
    solutions."""
    columns = np.flatnonzero(free)
    with np.errstate(all="ignore"):
        for _ in range(MAX_ITERATIONS):
            shape = (7, 1 + columns.size, values.shape[1])
            near = np.broadcast_to(values[:, None], shape).copy()
            near[columns, np.arange(columns.size) + 1] += DIFFERENCE_STEP
            found = np.asarray(_misses(request, near, signs[:, None]))
            slopes = (found[:, 1:] - found[:, :1]) / DIFFERENCE_STEP * SCALE[columns, None]
            slopes, miss = np.moveaxis(np.nan_to_num(slopes), -1, 0), np.nan_to_num(found[:, 0].T)
            steps = -np.einsum("nfc,nc->fn", np.linalg.pinv(slopes, rcond=1e-10), miss)
            values = values.copy()
            values[columns] += SCALE[columns, None] * steps / np.maximum(1.0, np.abs(steps).max(axis=0))
        found = _misses(request, values, signs)
    return values, np.isfinite(found).all(axis=0) & (np.abs(found).max(axis=0) < TOLERANCE)


def answers(request: Request, design: Design) -> bool:
    """Return whether a pair meets the request and has no warning."""
    closing = layout_deviation(design)
    met = abs(closing.normal_backlash - request.backlash) < 1e-6 and abs(closing.offset_difference) < 1e-6
    if request.crossing is not None:
        angle = abs(float(generator_angle_as_mounted(design, request.flank)))
        met &= abs(angle - request.crossing) < radians(1e-4)
    return bool(met) and quiet(design_remarks(design, closing, backlash_report(design).jam))


def grid_search_solves(request: Request) -> Design | None:
    """Return a pair of the grid without a warning of `check`, None without one."""
    values = pairs_on_grid(request)
    if not values.size:
        return None
    values = values[:, np.sort(np.unique(np.round(values, 4), axis=1, return_index=True)[1])]
    criteria = criteria_of(request, values, tooth_criteria(request, values))
    possible = np.flatnonzero(criteria.possible)
    best = possible[np.argsort(-criteria.reserve[possible])][:MAX_CHECKS]
    tried = (design_of(request, values[:, k]) for k in best)
    return next((design for design in tried if answers(request, design)), None)
