"""Contact patterns of a pair under two assembly errors: a square matrix of patterns.

Each cell is the design with two values added to its errors. Mesh cycles and backlash of all cells are
computed in one call, patterns one by one. Cells that cannot be assembled have no pattern."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Codes, FloatArray, Mask, flank_sign
from ..contact.ellipse import MARKING_SEPARATION_MM
from ..design.arguments import require_numbers, require_single, require_two_numbers
from ..design.model import Design
from ..operation.backlash import mounted_backlash
from ..operation.contact_pattern.motion import first_contact_operation
from ..operation.contact_pattern.pattern import RELATIVE_AREA_ERROR, ContactPattern, contact_pattern
from ..operation.mesh_cycle import mesh_cycle
from ..pair.misalignment import ALL_NAMES, errors_below, mounted, place_of, size_words
from ..status import FirstStatus
from ..support.argument import ArgumentError
from ..support.array_repr import short_repr
from .pattern_ellipse import MarkedEllipse, marked_ellipse
from .tolerance import USUAL_AT


@dataclass(frozen=True, eq=False)
class PatternCell:
    """The `pattern` of a cell and its ellipses on pinion and gear."""

    pattern: ContactPattern
    ellipses: tuple[MarkedEllipse, MarkedEllipse]


@dataclass(frozen=True, eq=False)
class PatternMatrix:
    """Contact patterns of one flank of a design under two errors.

    Attributes
    ----------
    separation : float
        Thickness of the marking compound, mm.
    over : tuple of str
        Names of the errors: the first changes from row to row, the second from column to column.
    first, second : FloatArray
        (n,), values added to the errors of the design, mm or rad.
    status : Codes
        (n, n), codes of `FirstStatus` of the mesh cycle.
    jammed : Mask
        (n, n), cells that cannot be assembled.
    normal_backlash : FloatArray
        (n, n), backlash as mounted, mm.
    cycle_peak_to_peak, edge_share : FloatArray
        (n, n), transmission error of all teeth, rad, and share of the cycle in which edges touch; NaN for
        cells without a pattern.
    cells : tuple of PatternCell or None
        Row by row; None for cells without a pattern.
    """

    __repr__ = short_repr

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
        """Values (n^2, 2) of both errors of each cell, row by row, mm or rad."""
        return np.stack(np.meshgrid(self.first, self.second, indexing="ij"), axis=-1).reshape(-1, 2)


def check_names(names: tuple[str, str], field: str) -> None:
    """Raise ValueError unless the names are two different errors, both about the common perpendicular or both
    at the mesh."""
    if len(names) != 2 or len(set(names)) != 2 or not set(names) <= set(ALL_NAMES):
        raise ValueError(
            f"{field} must be two different errors of {', '.join(ALL_NAMES)}, got {', '.join(names)}"
        )
    place_of(names)


def check_size(design: Design, name: str, size: float) -> None:
    """Raise ValueError unless the size of an error is positive and below its limit."""
    limit = errors_below(design).get(name, np.inf)
    if not 0.0 < size < limit:
        most = f" and less than {size_words(name, limit)} on this pair" if np.isfinite(limit) else ""
        text = f"must be positive{most}, got {size_words(name, size)}"
        raise ArgumentError(f"the size of the error of {name}", text)


def pattern_matrix(
    design: Design,
    over: tuple[str, str] = ("offset", "shaft_angle"),
    flank: str = "right",
    *,
    like: PatternMatrix | None = None,
    sizes: tuple[float, float] | None = None,
    cells: int = 3,
    separation: float = MARKING_SEPARATION_MM,
    resolution: float | None = None,
    area_error: float = RELATIVE_AREA_ERROR,
    progress: Callable[[int], object] | None = None,
) -> PatternMatrix:
    """Compute contact patterns under `cells` times `cells` values of two errors, evenly spaced from minus to
    plus their size.

    Parameters
    ----------
    design : Design
        A single design.
    over : (str, str)
        Names of two errors: the first changes from row to row, the second from column to column.
    flank : {'right', 'left'}
    like : PatternMatrix, optional
        Matrix of the other flanks under the same errors. Its backlash is used, because backlash belongs to
        both flanks.
    sizes : (float, float), optional
        Largest value of each error, mm or rad; the usual tolerances (`tolerance.USUAL_AT`) by default.
    cells : {3, 5}
    separation, resolution, area_error
        Settings of each pattern, as in `contact_pattern`.
    progress : callable, optional
        Called with the number of cells computed since the last call.

    Returns
    -------
    PatternMatrix

    Raises
    ------
    ValueError
        For a batch; for unknown errors or sizes outside their limits; for another number of cells; for `like`
        with other errors; if the tip rounds of a tool overlap; and as in `contact_pattern`.

    References
    ----------
    Definitions: beveloid_geom/analysis/README.md, Contact patterns under errors.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> matrix = bg.pattern_matrix(bg.builtin_design("ni-2017"), ("offset", "shaft_angle"), cells=3)
    >>> int(matrix.jammed.sum()), matrix.first
    (1, array([-0.05,  0.  ,  0.05]))
    """
    require_single(design)
    flank_sign(flank)
    check_names(over, "over")
    require_numbers(separation=separation, resolution=resolution, area_error=area_error)
    require_two_numbers(sizes=sizes)
    if cells not in (3, 5):
        raise ValueError(f"cells must be 3 or 5, got {cells!r}")
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
    pattern_cells: list[PatternCell | None] = []
    for k, (pair, good) in enumerate(zip(values.reshape(-1, 2), runs.ravel(), strict=True)):
        pattern_cells.append(None)
        if good:
            alone = mounted(design, pair, over)
            operation = first_contact_operation(alone, flank, cycle, k)
            one = contact_pattern(alone, flank, separation, operation=operation, **settings)
            ellipses = marked_ellipse(one.pinion, separation), marked_ellipse(one.gear, separation)
            pattern_cells[-1] = PatternCell(one, ellipses)
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
        cells=tuple(pattern_cells),
    )


def _play_of(
    design: Design, over: tuple[str, str], values: FloatArray, mountings: Design, like: PatternMatrix | None
) -> tuple[FloatArray, Mask]:
    """Return the normal backlash (n, n), mm, of the cells of a matrix, and which cells jam.

    Both are taken from the matrix `like` if it is given. Raises ValueError if this has other errors."""
    if like is None:
        backlash = mounted_backlash(mountings)
        return backlash.normal, backlash.jammed
    alike = like.design is design and like.over == over
    if not alike or not np.array_equal(like.added, values.reshape(-1, 2)):
        raise ValueError("like must be a matrix of the same design under the same errors: leave it out")
    return like.normal_backlash, like.jammed
