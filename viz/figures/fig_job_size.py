"""Time and memory of paths of contact against the size of the job."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from beveloid_geom.inputs import Design
from beveloid_geom.job_size import (
    CASES,
    CASES_PER_BLOCK,
    POSITIONS,
    POSITIONS_PER_BLOCK,
    SIZES,
    TRACED_CASES,
    Job,
    job_sizes,
)

from .. import theme
from ..recipe import Drawing, Recipe, Table
from ..theme import Size
from .curves import Look, curve, duration, log_axes, say

FLANK = "right"
JOBS = SIZES
MEGA = 1e6
LOOKS = {
    (POSITIONS, False): Look("positions of a path, in one call", theme.GREEN, "D", True, 8.5),
    (POSITIONS, True): Look("positions of a path, in blocks", theme.GREEN, "D"),
    (CASES, False): Look("misalignment cases, in one call", theme.BLUE, "s", True, 8.5),
    (CASES, True): Look("misalignment cases, in blocks", theme.BLUE, "s"),
}
NOTE = (
    "A position is all that a path holds of it. A misalignment case is a mounted pair of its own, with the"
    f" exact ends of its path and its contact ratio. Blocks are {POSITIONS_PER_BLOCK:,} positions and"
    f" {CASES_PER_BLOCK:,} cases, each reduced to a number before the next is made. Peak memory is what a job"
    f" allocates at most at a time (tracemalloc; in blocks of cases, over the first {TRACED_CASES:,})."
    " {finding}"
)


@dataclass(frozen=True, eq=False)
class JobFigure:
    """Jobs, or the `reason` why there are none."""

    jobs: tuple[Job, ...]
    reason: str = ""

    def of(self, unit: str, in_blocks: bool) -> list[Job]:
        """The jobs of one kind that were done, by size."""
        kind = [job for job in self.jobs if (job.unit, job.in_blocks) == (unit, in_blocks)]
        return [job for job in kind if np.isfinite(job.seconds)]


def compute(design: Design) -> JobFigure:
    """Jobs on the right flanks."""
    try:
        return JobFigure(job_sizes(design, FLANK, JOBS))
    except ValueError as error:
        return JobFigure((), str(error))


def draw(data: JobFigure, size: Size) -> Drawing:
    """Time, and memory, over the size of the job."""
    page = theme.new_page(
        size,
        "Time and memory against the size of the job",
        f"Paths of contact on the {FLANK} flanks, in one call and block by block",
    )
    low = theme.caption(page, NOTE.format(finding=finding(data))) + theme.inches(page, 0.75)
    height = theme.top(page) - theme.inches(page, 0.5) - low
    for column, label in enumerate(("processor time (s)", "peak memory (MB)")):
        axes = page.add_axes((0.075 + 0.495 * column, low, 0.415, height))
        axes.set_title(f"({'ab'[column]})  {label.split(' (')[0]}", loc="left", pad=10.0)
        axes.set_xlabel("positions, or misalignment cases, in the job")
        axes.set_ylabel(label)
        log_axes(axes)
        axes.set_xlim(0.6, 2e7)
        axes.set_xticks(10.0 ** np.arange(8))
        if data.reason:
            say(axes, data.reason)
            continue
        for order, (kind, look) in enumerate(LOOKS.items()):
            jobs = data.of(*kind)
            values = [job.peak_bytes / MEGA if column else job.seconds for job in jobs]
            curve(axes, look, [job.size for job in jobs], values, order)
        axes.autoscale_view(scalex=False)
        axes.minorticks_off()
        if column == 0:
            axes.legend(loc="upper left")
    return Drawing(page, {})


def finding(data: JobFigure) -> str:
    """What the chart shows, in numbers of this run."""
    parts = [_part(unit, data.of(unit, False), data.of(unit, True)) for unit in (POSITIONS, CASES)]
    undone = [f"{job.size:,} {job.unit} were {job.status}" for job in data.jobs if np.isnan(job.seconds)]
    return "; ".join(part for part in (*parts, *undone) if part) + "." if any(parts) else ""


def _part(unit: str, whole: Sequence[Job], blocks: Sequence[Job]) -> str:
    if not (whole and blocks):
        return ""
    last, largest = blocks[-1], whole[-1]
    return (
        f"{last.size:,} {unit} in blocks take {duration(last.seconds)}, {duration(last.seconds / last.size)}"
        f" each, and {last.peak_bytes / MEGA:.3g} MB; {largest.size:,} in one call take"
        f" {duration(largest.seconds)} and {largest.peak_bytes / MEGA:.3g} MB"
    )


def rows(data: JobFigure) -> Table:
    """Time and memory of every job."""
    header = ("unit", "way", "size", "seconds", "seconds_per_unit", "peak_memory_bytes", "status")

    def body() -> Iterator[list[object]]:
        if data.reason:
            yield ["", "", "", float("nan"), float("nan"), float("nan"), data.reason]
        for job in data.jobs:
            way = "blocks" if job.in_blocks else "one call"
            yield [job.unit, way, job.size, job.seconds, job.seconds / job.size, job.peak_bytes, job.status]

    return header, body()


RECIPES = {"job-size": Recipe(compute, draw, rows)}
