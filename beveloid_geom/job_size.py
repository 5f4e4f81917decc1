"""Processor time and peak memory of paths of contact against the size of the job.

The jobs are positions along one path, and misalignment cases, each with the ends of its path and its
contact ratio. Both are done in one call, whose memory grows with the job, and block by block, each
block reduced to a number before the next: then memory is that of a block, however long the job.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np

from .comparison import CLOCK
from .inputs import Design, Errors
from .path import path_blocks, path_ends, path_of_contact

POSITIONS = "positions of a path"
CASES = "misalignment cases"
SPREAD = 0.1
"""mm: offset errors of the cases lie evenly within it on either side."""
POSITIONS_PER_BLOCK, CASES_PER_BLOCK = 65_536, 1_000
TRACED_CASES = 10_000
"""Cases in blocks over which memory is traced: tracing many short arrays takes longer than the job."""
BRIEF, REPEAT = 0.05, 3
"""s: jobs under it are measured as often, and the least time counts."""
LONGEST, RULING = 20.0, 100
"""s: a job that would take longer, by one of RULING units or more before it, is not done."""
SIZES = {
    (POSITIONS, False): tuple(10**k for k in range(1, 7)),
    (POSITIONS, True): tuple(10**k for k in range(1, 8)),
    (CASES, False): tuple(10**k for k in range(5)),
    (CASES, True): tuple(10**k for k in range(6)),
}
"""Of the jobs, by unit and whether in blocks; those in one call end where memory asks for blocks."""


@dataclass(frozen=True)
class Job:
    """A job of `size` units, POSITIONS or CASES, in blocks or in one call: its time, and the most bytes
    it allocates at a time; NaN where it was not done, and `status` then says why, else "solved"."""

    unit: str
    in_blocks: bool
    size: int
    seconds: float
    peak_bytes: float
    status: str = "solved"


def blocks_of(design: Design, flank: str, unit: str, in_blocks: bool, size: int) -> Iterator[float]:
    """Do a job; a number for each block: the greatest contact radius on the pinion (mm) of positions,
    the greatest contact ratio of cases."""
    if unit == POSITIONS and not in_blocks:
        yield float(path_of_contact(design, flank, size).pinion_r.max())
    elif unit == POSITIONS:
        for part in path_blocks(design, flank, size, positions_per_block=POSITIONS_PER_BLOCK):
            yield float(part.pinion_r.max())
    else:
        step = CASES_PER_BLOCK if in_blocks else size
        for first in range(0, size, step):
            share = np.arange(first, min(first + step, size)) / max(1, size - 1)
            cases = design.with_errors(Errors(offset=SPREAD * (2.0 * share - 1.0)))
            yield float(path_ends(cases, flank).contact_ratio.max())


def measured(blocks: Callable[[], Iterator[float]], traced: int | None = None) -> tuple[float, int]:
    """Seconds of a job, and the most bytes allocated at a time in its first `traced` blocks, or in all."""
    times: list[float] = []
    while not times or (times[0] < BRIEF and len(times) < REPEAT):
        begin = CLOCK()
        for _ in blocks():
            pass
        times.append(CLOCK() - begin)
    tracemalloc.start()
    try:
        for _ in islice(blocks(), traced):
            pass
        return min(times), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def job_sizes(
    design: Design, flank: str = "right", sizes: Mapping[tuple[str, bool], Sequence[int]] = SIZES
) -> tuple[Job, ...]:
    """Time and memory of the jobs of these `sizes`, by unit and whether in blocks.

    Errors of the design are replaced in the cases. Raises ValueError where the flanks have no
    contact."""
    if not path_of_contact(design, flank, 2).l1.size:
        raise ValueError(f"the {flank} flanks have no path of contact of which to make a job")
    jobs: list[Job] = []
    for (unit, in_blocks), wanted in sizes.items():
        traced = TRACED_CASES // CASES_PER_BLOCK if unit == CASES else None
        rate = 0.0  # of the job before, in s
        for size in wanted:
            if rate * size > LONGEST:
                nothing, reason = float("nan"), f"not done: would take about {rate * size:.0f} s"
                jobs.append(Job(unit, in_blocks, size, nothing, nothing, reason))
                continue
            work = partial(blocks_of, design, flank, unit, in_blocks, size)
            jobs.append(Job(unit, in_blocks, size, *measured(work, traced)))
            rate = jobs[-1].seconds / size if size >= RULING else 0.0
    return tuple(jobs)
