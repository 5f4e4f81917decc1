"""Processor time and peak memory of paths of contact against the size of the job.

The jobs are positions along one path, and misalignment cases, each with the ends of its path and its
contact ratio. Both are done in one call, whose memory grows with the job, and block by block, each
block reduced to a number before the next: then memory is that of a block, however long the job.
A block of cases has as many as stay within BLOCK_BYTES: paths that are followed by their length take
some twenty times the memory of others.
"""

from __future__ import annotations

import tracemalloc
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np

from ..arrays import FloatArray
from ..contact.path import path_blocks, path_ends, path_of_contact
from ..design.model import Design, Errors
from .comparison import CLOCK
from .comparison_methods import one_design, whole_numbers

POSITIONS = "positions of a path"
CASES = "misalignment cases"
SPREAD = 0.1
"""mm: offset errors of the cases lie evenly within it on either side."""
POSITIONS_PER_BLOCK, CASES_PER_BLOCK = 65_536, 1_000
BLOCK_BYTES, PROBES = 80e6, 11
"""Bytes within which a block of cases should stay, by what the slowest of PROBES cases takes; it has
CASES_PER_BLOCK at most."""
TRACED_BLOCKS = 2
"""Blocks of cases over which memory is traced: tracing many short arrays takes longer than the job."""
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
    """A job of `size` units, POSITIONS or CASES, in blocks of `per_block` or, where that is None, in one
    call: its time, and the most bytes it allocates at a time; NaN where it was not done, and `status`
    then says why, else "solved". `expected` are the seconds (s) that it would have taken."""

    unit: str
    per_block: int | None
    size: int
    seconds: float
    peak_bytes: float
    status: str = "solved"
    expected: float = float("nan")

    @property
    def in_blocks(self) -> bool:
        """Whether it was done block by block."""
        return self.per_block is not None


def blocks_of(design: Design, flank: str, unit: str, per_block: int | None, size: int) -> Iterator[float]:
    """Do a job; a number for each block: the greatest contact radius on the pinion (mm) of positions,
    the greatest contact ratio of cases."""
    if unit == POSITIONS and per_block is None:
        yield float(path_of_contact(design, flank, size).pinion_r.max())
    elif unit == POSITIONS:
        for part in path_blocks(design, flank, size, positions_per_block=per_block or size):
            yield float(part.pinion_r.max())
    else:
        step = per_block or size
        for first in range(0, size, step):
            share = np.arange(first, min(first + step, size)) / max(1, size - 1)
            cases = design.with_errors(Errors(offset=_offsets(share)))
            yield float(path_ends(cases, flank).contact_ratio.max())


def _offsets(share: FloatArray) -> FloatArray:
    """Offset errors (mm) of cases at a share of their row."""
    return np.asarray(SPREAD * (2.0 * share - 1.0))


def cases_per_block(design: Design, flank: str) -> int:
    """How many cases fit into BLOCK_BYTES, of one digit and zeros, and not more than CASES_PER_BLOCK."""
    cases = [
        design.with_errors(Errors(offset=offset)) for offset in _offsets(np.linspace(0, 1, PROBES)).tolist()
    ]
    times = []
    for case in cases:
        begin = CLOCK()
        path_ends(case, flank)
        times.append(CLOCK() - begin)
    slowest = cases[int(np.argmax(times[1:])) + 1]  # the first call also pays for what is kept
    fit = max(1.0, BLOCK_BYTES / max(1, _peak(lambda: path_ends(slowest, flank))))
    digit = 10.0 ** np.floor(np.log10(fit))
    return int(min(CASES_PER_BLOCK, np.floor(fit / digit) * digit))


def measured(blocks: Callable[[], Iterator[float]], traced: int | None = None) -> tuple[float, int]:
    """Seconds of a job, and the most bytes allocated at a time in its first `traced` blocks, or in all."""
    times: list[float] = []
    while not times or (times[0] < BRIEF and len(times) < REPEAT):
        begin = CLOCK()
        for _ in blocks():
            pass
        times.append(CLOCK() - begin)
    return min(times), _peak(lambda: deque(islice(blocks(), traced), maxlen=0))


def _peak(work: Callable[[], object]) -> int:
    """The most bytes allocated at a time."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def job_sizes(
    design: Design, flank: str = "right", sizes: Mapping[tuple[str, bool], Sequence[int]] = SIZES
) -> tuple[Job, ...]:
    """Time and memory of the jobs of these `sizes`, by unit and whether in blocks.

    Errors of the design are replaced in the cases. Raises TypeError for what is no design, ValueError
    for a batch of designs, for a unit or a size that there is not, and where the flanks have no
    contact."""
    _check(design, flank, sizes)
    per_block = {POSITIONS: POSITIONS_PER_BLOCK, CASES: CASES_PER_BLOCK}
    if (CASES, True) in sizes:
        per_block[CASES] = cases_per_block(design, flank)
    jobs: list[Job] = []
    for (unit, in_blocks), wanted in sizes.items():
        block = per_block[unit] if in_blocks else None
        traced = TRACED_BLOCKS if unit == CASES else None
        rate = 0.0  # of the job before, in s
        for size in wanted:
            if rate * size > LONGEST:
                nothing, reason = float("nan"), f"not done: would take about {rate * size:.0f} s"
                jobs.append(Job(unit, block, size, nothing, nothing, reason, rate * size))
                continue
            work = partial(blocks_of, design, flank, unit, block, size)
            jobs.append(Job(unit, block, size, *measured(work, traced)))
            rate = jobs[-1].seconds / size if size >= RULING else 0.0
    return tuple(jobs)


def _check(design: Design, flank: str, sizes: Mapping[tuple[str, bool], Sequence[int]]) -> None:
    one_design(design, "jobs are measured")
    for (unit, _), wanted in sizes.items():
        if unit not in (POSITIONS, CASES):
            raise ValueError(f"units of a job are {POSITIONS!r} and {CASES!r}, got {unit!r}")
        whole_numbers(f"sizes of {unit}", wanted, 2 if unit == POSITIONS else 1)
    if not path_of_contact(design, flank, 2).l1.size:
        raise ValueError(f"the {flank} flanks have no path of contact of which to make a job")
