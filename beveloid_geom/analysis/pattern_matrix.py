"""The marking pattern of a pair under two assembly errors: a square matrix of patterns.

Each cell is the design with the values of two errors added to those it has. Mesh cycles and backlash of all
cells are found in one call, patterns one by one. What cannot be assembled gets no pattern: nothing runs so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Codes, FloatArray, Mask, flank_sign
from ..contact.ellipse import MARKING_SEPARATION
from ..design.model import Design
from ..operation.backlash import mounted_backlash
from ..operation.marking.operating_rolls import first_contact_operation
from ..operation.marking.pattern import AREA_ERROR, ContactPattern, contact_pattern
from ..operation.mesh_cycle import mesh_cycle
from ..pair.errors import ALL_NAMES, errors_below, mounted, place_of
from ..status import FirstStatus
from ..support.few_lines import few_lines
from .marked_ellipse import MarkedEllipse, marked_ellipse
from .tolerance import USUAL_AT

CELLS = (3, 5)
"""Cells along a side that a matrix may have."""


@dataclass(frozen=True, eq=False)
class PatternCell:
    """The `pattern` of one cell and its ellipses on pinion and gear."""

    pattern: ContactPattern
    ellipses: tuple[MarkedEllipse, MarkedEllipse]


@dataclass(frozen=True, eq=False)
class PatternMatrix:
    """Patterns of a design's `flank` under two errors, by their names: `over`.

    `first`, `second` (n): values added to the design's own errors, mm or rad. Arrays (n, n), the first error
    down the rows: `status`, codes of `FirstStatus` of the mesh cycle; `jammed`, whether the pair cannot be
    assembled; `normal_backlash` as mounted, mm; of what can run, else NaN, `cycle_peak_to_peak`, rad, the
    transmission error of all teeth, and `edge_share`, what edges carry of the cycle. `cells` in the order of
    rows, None where nothing runs."""

    __repr__ = few_lines

    design: Design
    flank: str
    separation: float
    over: tuple[str, str]
    first: FloatArray
    second: FloatArray
    status: Codes
    jammed: Mask
    normal_backlash: FloatArray
    cycle_peak_to_peak: FloatArray
    edge_share: FloatArray
    cells: tuple[PatternCell | None, ...]

    @property
    def added(self) -> FloatArray:
        """The values (n n, 2) of both errors of each cell, mm or rad."""
        return np.stack(np.meshgrid(self.first, self.second, indexing="ij"), axis=-1).reshape(-1, 2)


def check_names(names: tuple[str, str], field: str) -> None:
    """Raise ValueError unless these are two different errors of one place."""
    if len(names) != 2 or len(set(names)) != 2 or not set(names) <= set(ALL_NAMES):
        raise ValueError(
            f"{field} must be two different ones of {', '.join(ALL_NAMES)}, got {', '.join(names)}"
        )
    place_of(names)


def check_size(design: Design, name: str, size: float) -> None:
    """Raise ValueError unless the size of an error is positive and below its limit."""
    own = errors_below(design).get(name, np.inf)
    if not 0.0 < size < own:
        most = f", less than {own:g} on this pair" if np.isfinite(own) else ""
        raise ValueError(f"the size of the error of {name} must be positive, mm or rad{most}, got {size:g}")


def pattern_matrix(
    design: Design,
    over: tuple[str, str] = ("offset", "shaft_angle"),
    flank: str = "right",
    *,
    like: PatternMatrix | None = None,
    sizes: tuple[float, float] | None = None,
    cells: int = CELLS[0],
    separation: float = MARKING_SEPARATION,
    resolution: float | None = None,
    area_error: float = AREA_ERROR,
    progress: Callable[[int], object] | None = None,
) -> PatternMatrix:
    """Find patterns under `cells` times `cells` values of two errors, evenly from minus to plus their size.

    Parameters
    ----------
    design : Design
        A single one.
    over : (str, str)
        Names of two errors: down the rows, and from column to column.
    flank : {'right', 'left'}
    sizes : (float, float), optional
        Greatest value of each, mm or rad; the usual tolerances (`tolerance.USUAL_AT`) if not given.
    cells : {3, 5}
    separation, resolution, area_error
        Of each pattern, as in `contact_pattern`.
    like : PatternMatrix, optional
        That of the other flanks under the same errors: its backlash is that of both.
    progress : callable, optional
        Called with the number of cells done since.

    Raises
    ------
    ValueError
        For a batch, errors without a name or a size, another number of cells, `like` of other errors, where a
        tool's rounds overlap, and as `contact_pattern`.
    """
    flank_sign(flank)
    check_names(over, "over")
    if design.batch_shape:
        raise ValueError("a matrix of patterns takes a single design: give its cases one by one")
    if cells not in CELLS:
        raise ValueError(f"cells must be {' or '.join(map(str, CELLS))}, got {cells}")
    usual = USUAL_AT[place_of(over)]
    sizes = (getattr(usual, over[0]), getattr(usual, over[1])) if sizes is None else sizes
    for name, size in zip(over, sizes, strict=True):
        check_size(design, name, size)
    first, second = (size * np.linspace(-1.0, 1.0, cells) for size in sizes)
    values = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1)
    mountings = mounted(design, values, over)
    cycle = mesh_cycle(mountings, flank, 1)
    backlash, jammed = _play_of(design, over, values, mountings, like)
    runs = (cycle.status == FirstStatus.SOLVED) & ~jammed
    settings: Any = {"resolution": resolution, "area_error": area_error}
    found: list[PatternCell | None] = []
    for k, (pair, good) in enumerate(zip(values.reshape(-1, 2), runs.ravel(), strict=True)):
        found.append(None)
        if good:
            alone = mounted(design, pair, over)
            operation = first_contact_operation(alone, flank, cycle, k)
            one = contact_pattern(alone, flank, separation, operation=operation, **settings)
            ellipses = marked_ellipse(one.pinion, separation), marked_ellipse(one.gear, separation)
            found[-1] = PatternCell(one, ellipses)
        if progress is not None:
            progress(1)
    return PatternMatrix(
        design=design,
        flank=flank,
        separation=separation,
        over=over,
        first=first,
        second=second,
        status=cycle.status.astype(np.int8),
        jammed=jammed,
        normal_backlash=backlash,
        cycle_peak_to_peak=np.where(runs, cycle.peak_to_peak, np.nan),
        edge_share=np.where(runs, cycle.edge_share, np.nan),
        cells=tuple(found),
    )


def _play_of(
    design: Design, over: tuple[str, str], values: FloatArray, mountings: Design, like: PatternMatrix | None
) -> tuple[FloatArray, Mask]:
    """Give normal backlash, mm, of a matrix and whether it is jammed, (n, n), by a matrix of the same errors
    if there is one. Raises ValueError for one of others."""
    if like is None:
        found = mounted_backlash(mountings)
        return found.normal, found.jammed
    alike = like.design is design and like.over == over
    if not alike or not np.array_equal(like.added, values.reshape(-1, 2)):
        raise ValueError("like must be a matrix of the same design under the same errors")
    return like.normal_backlash, like.jammed
