"""Time and memory of paths of contact against the size of the job."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from beveloid_geom.design.model import Design
from beveloid_geom.studies.job_size import (
    BLOCK_BYTES,
    CASES,
    CASES_PER_BLOCK,
    LONGEST,
    POSITIONS,
    SIZES,
    TRACED_BLOCKS,
    Job,
    job_sizes,
)

from ...parts.curves import Look, curve, duration, log_axes, say, whole_decades
from ...parts.recipe import Drawing, Recipe, Table
from ...stage import theme
from ...stage.scene import Size

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
    "A position has every quantity of a path: parameters, rolls, point, normal, transmission error."
    " A misalignment case is a mounted pair of its own, with the"
    " exact ends of its path and its contact ratio. {blocks}Peak memory is what a job allocates at most at a"
    f" time (tracemalloc; in blocks of cases, over the first {TRACED_BLOCKS} blocks). {{finding}}"
)


@dataclass(frozen=True, eq=False)
class JobFigure:
    """Jobs, or the `reason` why there are none."""

    jobs: tuple[Job, ...]
    reason: str = ""

    def of(self, unit: str, in_blocks: bool) -> list[Job]:
        """The jobs of one kind that were done, by size."""
        return [job for job in self.kind(unit, in_blocks) if np.isfinite(job.seconds)]

    def kind(self, unit: str, in_blocks: bool) -> list[Job]:
        """The jobs of one kind, done or not."""
        return [job for job in self.jobs if (job.unit, job.in_blocks) == (unit, in_blocks)]


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
    note = NOTE.format(blocks=block_sizes(data), finding=finding(data))
    low = theme.caption(page, note, 176) + theme.inches(page, 0.75)
    height = theme.top(page) - theme.inches(page, 0.9) - low
    page.legend(
        handles=[look.line() for look in LOOKS.values()],
        loc="center left",
        bbox_to_anchor=(0.068, theme.top(page) - theme.inches(page, 0.15)),
        ncols=len(LOOKS),
        fontsize=theme.SMALL,
        handlelength=3.2,
    )
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
        whole_decades(axes)
        axes.minorticks_off()
    return Drawing(page, {})


def block_sizes(data: JobFigure) -> str:
    """How large the blocks are, and why those of cases are smaller than they may be."""
    blocks = {job.unit: job.per_block for job in data.jobs if job.per_block is not None}
    if not blocks:
        return ""
    sizes = " and ".join(f"{per_block:,} {unit}" for unit, per_block in blocks.items())
    text = f"Blocks are {sizes}, each reduced to a number before the next is made. "
    if blocks.get(CASES, CASES_PER_BLOCK) < CASES_PER_BLOCK:
        text += (
            f"{CASES_PER_BLOCK:,} cases are usual, but here so many would take more than"
            f" {BLOCK_BYTES / MEGA:.0f} MB: paths that are followed by their length take more. "
        )
    return text


def finding(data: JobFigure) -> str:
    """What the chart shows, in numbers of this run."""
    parts = [_part(unit, data.of(unit, False), data.of(unit, True)) for unit in (POSITIONS, CASES)]
    undone = [_undone(unit, way, data.kind(unit, way)) for unit, way in LOOKS]
    text = "; ".join(part for part in parts if part)
    missing = "; ".join(part for part in undone if part)
    if missing:
        missing = f" Not done, as they would take more than {LONGEST:.0f} s: {missing}."
    return (text and f"{text}.") + missing


def _undone(unit: str, in_blocks: bool, jobs: Sequence[Job]) -> str:
    """Which jobs of one kind were not done, and how long they would have taken."""
    left = [f"{job.size:,} (about {job.expected:,.0f} s)" for job in jobs if np.isnan(job.seconds)]
    return f"{unit} {'in blocks' if in_blocks else 'in one call'}: {', '.join(left)}" if left else ""


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
    header = (
        "unit",
        "way",
        "per_block",
        "size",
        "seconds",
        "seconds_per_unit",
        "peak_memory_bytes",
        "status",
    )

    def body() -> Iterator[list[object]]:
        if data.reason:
            yield ["", "", "", "", float("nan"), float("nan"), float("nan"), data.reason]
        for job in data.jobs:
            way = "blocks" if job.in_blocks else "one call"
            cost = (job.seconds, job.seconds / job.size, job.peak_bytes)
            yield [job.unit, way, job.per_block or job.size, job.size, *cost, job.status]

    return header, body()


RECIPES = {"job-size": Recipe(compute, draw, rows)}
