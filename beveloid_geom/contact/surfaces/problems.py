"""The equations of tangency of a design, by members and placement, and flanks that touch along lines.

Members are single, the placement (errors, offset, shaft angle, mounting) may be a batch. Batches of members
are divided into pairs of different members.

On parallel axes, unmodified flanks touch along lines in the cases of `along_lines`, for example without
parabolas. Modified flanks still do where the modifications do not vary along these lines, as on spur gears
with tip relief, or where neither flank is relieved. Every point of these lines is a contact, so that the
equations have no single solution. The pinion then has an additional helix crowning of LINE_CROWNING_MODULES:
the contact on each line is now the point nearest to mid-face, which is the limit for crownings that tend to
zero. Searches for a first contact use it as well (`with_line_crowning`), also for flanks with parabolas but
without modifications.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import MEMBERS, FloatArray, Integers
from ...design.member import Tool, unchecked
from ...design.model import Design
from ...design.modification import Modification
from ...gear.tooth_side import flank_surface, is_batch, surface_of
from ...pair.frames import layout_by_case
from ...pair.mounting import mounting_of
from ...support.frozen_arrays import cached
from ..flank_pair import FlankPair, generated_pairing, is_modified
from ..parallel.modified_lines import has_reliefs_only
from ..parallel.paths import along_lines
from .limits import Problem
from .tangency import Contacts, PairPlacement, Surfaces, contacts_at
from .tracing import grid_function

GRID_LINES = 33, 25
"""Lines along profile and face of the grid on which flanks are checked for contact in areas."""
LINE_CROWNING_MODULES = 1e-8
"""Additional crowning, in modules, of flanks that touch along lines. With less, fewer paths of helical pairs
are found, because their lines end where a relief begins."""


def problems_of(design: Design, flank: str, pairing: FlankPair) -> Iterator[tuple[Design, Integers, Problem]]:
    """Yield designs with single members, the numbers of their cases, and their problems.

    Cases with line contact are separate, and their pinion has the additional crowning."""
    lines = along_lines(pairing)
    for single, cases in by_members(design):
        for part in (cases[~lines[cases]], cases[lines[cases]]):
            if not part.size:
                continue
            problem = problem_of(single, flank, pairing, part)
            if lines[part[0]] and _touches_in_areas(single, flank, pairing, problem):
                problem = problem_of(_with_crowning(single, flank), flank, pairing, part)
                problem = replace(problem, line_contact=True)
            problem = replace(problem, generated_lines=bool(lines[part[0]]))
            yield single, part, problem


def with_line_crowning(design: Design, flank: str) -> tuple[Design, bool]:
    """Return the design for searches for the first contact, and whether its modified flanks touch along
    lines.

    If they do in all cases, the pinion gets the additional helix crowning of LINE_CROWNING_MODULES. `design`
    has single members."""
    if not is_modified(design, flank) and not design.has_parabola:  # these lines are known in closed form
        return design, False
    if not layout_by_case(design).parallel.all():
        return design, False
    lines = _are_lines(design, flank) if design.batch_shape else _cached_are_lines(design, flank)
    return _with_crowning(design, flank) if lines else design, lines


def _are_lines(design: Design, flank: str) -> bool:
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        pairing = generated_pairing(design, flank)
        if not along_lines(pairing).all():
            return False
        return _touches_in_areas(design, flank, pairing, problem_of(design, flank, pairing, np.arange(1)))


_cached_are_lines = cached(16)(_are_lines)


def _with_crowning(design: Design, flank: str) -> Design:
    """Return the design with the additional crowning of the pinion."""
    given = design.pinion.modification(flank) or Modification()
    amount = 1e3 * LINE_CROWNING_MODULES * float(design.pinion.tool.normal_module)
    more = replace(given, helix_crowning_um=given.helix_crowning_um + amount)
    return unchecked(design, pinion=unchecked(design.pinion, **{f"modification_{flank}": more}))


def _touches_in_areas(design: Design, flank: str, pairing: FlankPair, problem: Problem) -> bool:
    """Return whether the flanks of the first case of a problem touch at all corners of a cell of a grid on
    the pinion, or anywhere in a cell where no relief has begun."""
    # Sine of the angle between flanks that touch.
    largest_angle = 1e-8
    met = _on_grid(problem)
    touches = (met.error <= largest_angle) & met.opposed
    if _corners(touches.reshape(GRID_LINES)).all(axis=0).any():
        return True
    if not (is_modified(design, flank) and has_reliefs_only(design, flank)):
        return False
    # Contacts of the generated flanks, and their distances (reliefs, 33, 25) from the beginnings of reliefs.
    bare = {name: getattr(design, name).modified(None) for name in MEMBERS}
    met = _on_grid(problem_of(unchecked(design, **bare), flank, pairing, np.arange(1)))
    s1, z1, _, s2 = met.state
    pinion, gear = (surface_of(member, flank) for member in design.members)
    past = np.concatenate((pinion.past_reliefs(s1, z1), gear.past_reliefs(s2, met.z2)))
    corners = _corners(past.reshape(-1, *GRID_LINES))
    # Cells in which every distance is negative at a corner.
    return _negative_together(corners[..., (corners.min(axis=0) <= 0.0).all(axis=0)])


def _negative_together(corners: FloatArray) -> bool:
    """Return whether all rows of values are negative at one place of a cell, by bilinear interpolation
    between the values at its `corners` (4, rows, cells)."""
    # Narrow a grid around the smallest value of the largest row, which is nearly convex, in each cell.
    rounds, lines, narrowing = 4, 17, 4.0
    cells = np.arange(corners.shape[2])
    a = b = np.full(cells.size, 0.5)
    for k in range(rounds):
        steps = np.linspace(-0.5, 0.5, lines) / narrowing**k
        a, b = (np.clip(middle[:, None] + steps, 0.0, 1.0) for middle in (a, b))
        weights = [p[:, :, None] * q[:, None] for p in (1.0 - a, a) for q in (1.0 - b, b)]
        largest = np.einsum("cnij,crn->rnij", weights, corners).max(axis=0)
        if (largest < 0.0).any():
            return True
        row, column = np.divmod(largest.reshape(cells.size, lines**2).argmin(axis=1), lines)
        a, b = a[cells, row], b[cells, column]
    return False


def _on_grid(problem: Problem) -> Contacts:
    """Return the points with tangent profiles of the first case of a problem, on a grid of the pinion."""
    one = problem.cases(np.arange(1))
    state = grid_function(one, GRID_LINES)[0].reshape(4, -1)
    return contacts_at(one.surfaces, one.placed.of_cases(np.zeros(len(state[0]), dtype=int)), state)


def _corners(values: NDArray[Any]) -> NDArray[Any]:
    """Return the values (..., n, m) of a grid at the four corners of its cells, (4, ..., n - 1, m - 1)."""
    rows = values[..., :-1, :], values[..., 1:, :]
    return np.array([row[..., part] for row in rows for part in (slice(None, -1), slice(1, None))])


def problem_of(design: Design, flank: str, pairing: FlankPair, cases: Integers) -> Problem:
    """Return the problem of cases with the same single members."""
    pinion, gear = (surface_of(member, flank) for member in design.members)
    part = pairing if cases.size == len(pairing.branch) else pairing.cases(cases)
    lowest, highest, tip, half_width, taper = (
        np.asarray(values)[:, 0, 0]
        for values in (part.lowest, part.highest, part.tip, part.half_width, part.taper)
    )
    scale = np.array((highest[0] - lowest[0], 2.0 * half_width[0], 2.0 * np.pi / float(design.pinion.teeth)))
    edges = (pinion.crossing, gear.crossing) if part.edges else (None, None)
    count = cases.size
    layout = part.layout
    point = np.broadcast_to(mounting_of(design).pitch_point, (*design.batch_shape, 3)).reshape(-1, 3)
    point = point[cases] if len(point) > 1 else np.repeat(point, count, axis=0)
    cos, sin, offset = (
        np.broadcast_to(value, (count, 1))[:, 0]
        for value in (layout.cos_angle, layout.sin_angle, layout.offset)
    )
    position = np.broadcast_to(part.position, (2, count, 1))[..., 0]
    placed = PairPlacement(cos, sin, offset, position, point.T)
    ratio = float(design.pinion.teeth / design.gear.teeth)
    first, second = (flank_surface(member, flank) for member in design.members)
    surfaces = Surfaces(first, second, ratio, scale)
    return Problem(surfaces, placed, lowest, highest, tip, taper, half_width, edges)


def by_members(design: Design) -> Iterator[tuple[Design, Integers]]:
    """Iterate over the designs with different members, and the cases (batch axes in one) of each."""
    shape = design.batch_shape
    count = int(np.prod(shape))
    if not any(map(is_batch, design.members)):
        yield design, np.arange(count)
        return
    columns: list[FloatArray] = []

    def each(part: Any, change: Any) -> Any:
        """Return a tool, member or modification with `change` applied to its arrays, except for measured
        deviations, which are not batches."""
        values = {
            name: each(value, change) if isinstance(value, Tool | Modification) else change(value)
            for name, value in vars(part).items()
            if isinstance(value, Tool | Modification | np.ndarray)
        }
        return unchecked(part, **values)

    def noted(value: FloatArray) -> FloatArray:
        columns.append(np.broadcast_to(value, shape).reshape(-1))
        return value

    for member in design.members:
        each(member, noted)
    _, first, inverse = np.unique(np.stack(columns, axis=-1), axis=0, return_index=True, return_inverse=True)
    for k, case in enumerate(first.tolist()):
        pinion, gear = (
            each(member, lambda value, case=case: float(np.broadcast_to(value, shape).reshape(-1)[case]))
            for member in design.members
        )
        yield unchecked(design, pinion=pinion, gear=gear), np.flatnonzero(inverse.reshape(-1) == k)
