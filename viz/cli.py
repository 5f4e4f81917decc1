"""`render-figures`: all figures, the paper's and more, and the numbers behind each."""

from __future__ import annotations

import csv
import io
import os
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from beveloid_geom.cli.options import BUILTIN_DESIGN, Refusal, load_design, write_out
from beveloid_geom.support.whole_file import whole_file

from .figures import FIGURES, SETS, UNASKED, Figure
from .options import command, option, prepare_folder, require_drawing, size_option, writing

if TYPE_CHECKING:
    from beveloid_geom import Design

DEFAULT_OUT = Path("outputs/figures")
MOST_UNASKED = 4
"""Processes that are started unasked: each takes about 0.4 GB."""


def usable_cores() -> int:
    """Count the cores that this process may use, up to MOST_UNASKED."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on all systems
    return min(len(affinity(0)) if affinity else os.cpu_count() or 1, MOST_UNASKED)


def chosen_figures(names: Sequence[str], sets: Sequence[str] = ()) -> list[Figure]:
    """Give the figures named and those of the sets, the paper's first; without either those of UNASKED."""
    known = [figure.name for figure in FIGURES]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise Refusal([f"no figure named {', '.join(map(repr, unknown))}: there are {', '.join(known)}"])
    if not names:
        sets = sets or UNASKED
    return [figure for figure in FIGURES if figure.name in names or figure.set in sets]


@dataclass(frozen=True)
class Made:
    """A figure as it is written: its files `png` and `csv`, the triangles on it, and the seconds it took."""

    png: bytes
    csv: str
    triangles: int
    seconds: float


def make_figure(figure: Figure, design: Design, size: tuple[int, int]) -> Made:
    """Compute and draw one figure of `size` pixels."""
    from .stage import theme

    start = time.perf_counter()
    recipe = figure.recipe()
    data = recipe.compute(design)
    with theme.style():
        drawing = recipe.draw(data, size)
        png = theme.png_of(drawing.page)
    header, rows = recipe.rows(data)
    table = io.StringIO()
    csv.writer(table, lineterminator="\n").writerows((header, *rows))
    return Made(png, table.getvalue(), drawing.triangles, time.perf_counter() - start)


def made(
    figures: Sequence[Figure], design: Design, size: tuple[int, int], jobs: int
) -> Iterator[tuple[Figure, Made]]:
    """Give each figure as soon as it is made, by `jobs` processes. Those that measure time come last, made
    here while nothing else runs. Raises Refusal where a process is lost."""
    timed = [figure for figure in figures if figure.timed]
    others = [figure for figure in figures if not figure.timed]
    if min(jobs, len(others)) > 1:
        from concurrent.futures import as_completed
        from concurrent.futures.process import BrokenProcessPool

        from beveloid_geom.support.workers import workers

        with workers(min(jobs, len(others))) as pool:
            # The last of the list take longest: first, so that none is waited for alone.
            tasks = {pool.submit(make_figure, figure, design, size): figure for figure in reversed(others)}
            try:
                for task in as_completed(tasks):
                    yield tasks[task], task.result()
            except BrokenProcessPool:
                raise Refusal(
                    ["a process ended before its time, memory may be short: try --jobs 1"]
                ) from None
        others = []
    for figure in (*others, *timed):
        yield figure, make_figure(figure, design, size)


def write_figure(figure: Figure, found: Made, folder: Path) -> None:
    """Write picture and numbers into the folder; each file appears whole or not at all."""
    for suffix, content in ((".png", found.png), (".csv", found.csv.encode())):
        with whole_file(folder / f"{figure.name}{suffix}") as beside:
            beside.write_bytes(content)


def _list(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not context.resilient_parsing:
        write_out("".join(f"{figure.name}  {figure.set:7}  {figure.title}\n" for figure in FIGURES))
        context.exit()


@command("render-figures")
@click.option(
    "--list",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_list,
    help="List the figures, and stop.",
)
@click.option("--only", "names", metavar="NAME", multiple=True, help="Draw only this figure; repeatable.")
@click.option(
    "--set",
    "sets",
    type=click.Choice(SETS),
    multiple=True,
    show_default=" and ".join(UNASKED),
    help="Draw the figures of the paper, of results, of methods; repeatable.",
)
@option("--out", click.Path(path_type=Path), DEFAULT_OUT, "Folder for PNG and CSV files.", metavar="DIR")
@size_option("1600x1200")
@option("--design", str, BUILTIN_DESIGN, "Design file (TOML), or the built-in design's name.", metavar="FILE")
@click.option(
    "--jobs",
    type=click.IntRange(1, 64),
    default=usable_cores,
    show_default=f"the number of cores, up to {MOST_UNASKED}",
    help="Processes that draw.",
)
def main(
    names: tuple[str, ...], sets: tuple[str, ...], out: Path, size: tuple[int, int], design: str, jobs: int
) -> None:
    """Draw figures as PNG, each with the numbers behind it as CSV: those of Ni et al. 2017, results such as
    contact pattern and transmission error, and, if asked for, how fast and how exact the methods are."""
    figures = chosen_figures(names, sets)
    loaded = load_design(design)

    from tqdm import tqdm

    require_drawing()
    prepare_folder(out)
    begin = time.perf_counter()
    done: dict[str, Made] = {}
    with tqdm(total=len(figures), desc="figures", unit="figure", file=sys.stderr) as bar:
        for figure, found in made(figures, loaded, size, jobs):
            with writing(f"{figure.name} to {out}"):
                write_figure(figure, found, out)
            done[figure.name] = found
            bar.set_postfix_str(figure.name, refresh=False)
            bar.update()
    lines = [
        f"{figure.name}  {found.triangles:>9,} triangles  {found.seconds:5.2f} s  {figure.title}"
        for figure, found in ((figure, done[figure.name]) for figure in figures)
    ]
    drawn = "1 figure (PNG) and its" if len(lines) == 1 else f"{len(lines)} figures (PNG) and their"
    seconds = time.perf_counter() - begin
    lines.append(f"{drawn} numbers (CSV) are in {out.resolve()}, drawn in {seconds:.1f} s")
    write_out("\n".join(lines) + "\n")
