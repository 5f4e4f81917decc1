"""Command `render-figures`: draw figures and write the numbers behind each."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from beveloid_geom.cli.commands.workshop.grid import grid_options, measured_report
from beveloid_geom.cli.options import (
    BUILTIN_DESIGN,
    Refusal,
    block,
    given_options,
    load_design,
    note_equal_teeth,
    refuse_without,
    worker_processes,
    write_out,
)
from beveloid_geom.support.atomic_file import atomic_file

from .figures import DEFAULT_SETS, FIGURES, LOADED, MEASURED, SETS, Figure
from .options import (
    DEFAULT_PROCESSES,
    command,
    option,
    prepare_folder,
    require_drawing,
    size_option,
    usable_cores,
    writing,
)
from .rendering.layout import PageLayout, of_size, of_width

if TYPE_CHECKING:
    from beveloid_geom import Design
    from beveloid_geom.report.workshop.grid import DeviationReport

    from .figures.results.load_sharing import Loaded
    from .rendering.theme import Page


def chosen_figures(names: Sequence[str], sets: Sequence[str] = ()) -> list[Figure]:
    """Return the figures with these names and those of the sets; the default sets without either."""
    known = [figure.name for figure in FIGURES]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise Refusal([f"no figure named {', '.join(map(repr, unknown))}: known are {', '.join(known)}"])
    if not names:
        sets = sets or DEFAULT_SETS
    return [figure for figure in FIGURES if figure.name in names or figure.set in sets]


@dataclass(frozen=True)
class Made:
    """A finished figure: `files` by suffix, number of triangles, and time in seconds."""

    files: dict[str, bytes]
    triangles: int
    seconds: float


@dataclass(frozen=True)
class Job:
    """A figure to be drawn for a design, measured points or loaded teeth.

    `flank` is used if the figure shows one flank; `form` is png, pdf or svg."""

    figure: Figure
    design: Design | DeviationReport | Loaded
    flank: str
    layout: PageLayout
    form: str

    @property
    def name(self) -> str:
        """Name of the files without suffix."""
        return self.figure.name + ("-left" if self.figure.of_flank and self.flank == "left" else "")


def make_figure(job: Job) -> Made:
    """Compute and draw one figure. For a plain page, the text of the page is an additional file (txt)."""
    from beveloid_geom.report.result import csv_of

    from .rendering import files, theme

    start = time.perf_counter()
    recipe = job.figure.recipe()
    data = recipe.compute(job.design, *((job.flank,) if job.figure.of_flank else ()))
    drawing = recipe.drawn(data, job.layout)
    with theme.style():
        pages = {job.form: files.file_of(drawing.page, job.form)}
    pages["csv"] = csv_of(*recipe.rows(data)).encode()
    if job.layout.plain:
        pages["txt"] = theme.spelled(caption_of(drawing.page)).encode()
    return Made(pages, drawing.triangles, time.perf_counter() - start)


def caption_of(page: Page) -> str:
    """Return title, subtitle and note, a paragraph each, which a plain page leaves out."""
    return "".join(f"{words}\n\n" for words in (page.title, page.subtitle, page.note) if words)[:-1]


def made(jobs: Sequence[Job], processes: int) -> Iterator[tuple[Job, Made]]:
    """Yield each figure as soon as it is finished, using several processes.

    Figures that measure times are drawn last in this process. Raises Refusal if a process is lost."""
    timed = [job for job in jobs if job.figure.timed]
    others = [job for job in jobs if not job.figure.timed]
    if min(processes, len(others)) > 1:
        from concurrent.futures import as_completed

        with worker_processes(min(processes, len(others)), "try --jobs 1") as pool:
            # The last figures of the list take longest and are started first.
            tasks = {pool.submit(make_figure, job): job for job in reversed(others)}
            for task in as_completed(tasks):
                yield tasks[task], task.result()
        others = []
    for job in (*others, *timed):
        yield job, make_figure(job)


def write_figure(name: str, files_made: Made, folder: Path) -> None:
    """Write the files of a figure to the folder, each atomically."""
    for suffix, content in files_made.files.items():
        with atomic_file(folder / f"{name}.{suffix}") as temporary:
            temporary.write_bytes(content)


def solved_decks(design: Design, name: str, path: Path) -> Loaded:
    """Read the results of CalculiX for the decks of a pair in contact. Raises Refusal."""
    from .figures.results.load_sharing import loaded_pair

    try:
        return loaded_pair(design, path, name)
    except ValueError as error:
        raise Refusal([f"--loaded: {error}"]) from None
    except OSError as error:
        file = click.format_filename(error.filename or path)
        cure = "run ccx" if file.endswith(".dat") else "write it with beveloid-geom mesh --part pair"
        raise Refusal([f"--loaded: cannot read {file} ({error.strerror or error}): {cure} first"]) from None


def summary(drawn: Sequence[tuple[Job, Made]], where: str) -> str:
    """Return the summary for the user: a line for each figure, and the folder."""
    lines = [
        f"{job.name}  {drawing.triangles:>9,} triangles  {drawing.seconds:5.2f} s  {job.figure.title}"
        for job, drawing in drawn
    ]
    kind = f"({drawn[0][0].form.upper()})"
    what = f"1 figure {kind} and its" if len(lines) == 1 else f"{len(lines)} figures {kind} and their"
    return "\n".join((*lines, f"{what} {where}")) + "\n"


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
    help="List the figures and exit.",
)
@click.option(
    "--only", "names", metavar="NAME", multiple=True, help="Draw only this figure. Can be repeated."
)
@click.option(
    "--set",
    "sets",
    type=click.Choice(SETS),
    multiple=True,
    show_default=" and ".join(DEFAULT_SETS),
    help="Draw the figures of this set. Can be repeated.",
)
@option(
    "--out",
    click.Path(path_type=Path),
    "outputs/figures",
    "Folder for pictures and CSV files; a missing folder is created.",
    "DIR",
)
@size_option("1600x1200")
@click.option(
    "--width-mm",
    type=click.FloatRange(80, 260),
    metavar="MM",
    help="Width of a page in print, such as 90, 140 or 190, instead of --size. The text has 7 to 9 points."
    " The height follows from the figure; there are 300 pixels per inch.",
)
@click.option(
    "--plain",
    is_flag=True,
    help="Leave title, subtitle and note out of the picture and write them to the text file NAME.txt.",
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["png", "pdf", "svg"]),
    default="png",
    show_default=True,
    help="PDF and SVG contain vector graphics and text, with 3D pictures as images.",
)
@option(
    "--design", str, BUILTIN_DESIGN, "Design file (TOML), or the name of a built-in design.", metavar="FILE"
)
@click.option(
    "--flank",
    type=click.Choice(["right", "left", "both"]),
    default="right",
    show_default=True,
    help="Flanks of figures that show one flank; file names of left flanks end in -left.",
)
@option(
    "--measured",
    click.Path(path_type=Path),
    None,
    "Draw only the deviations of measured points. FILE has the points of the grid of the command `grid`;"
    " --member, --rows, --columns and --border define this grid and need --measured.",
    "FILE",
)
@option(
    "--loaded",
    click.Path(path_type=Path),
    None,
    "Draw only load sharing and transmission error. FILE is the --out of `mesh --part pair --rolls`; CalculiX"
    " must have solved its decks.",
    "FILE",
)
@block(*grid_options)
@click.option(
    "--jobs",
    type=click.IntRange(1, 64),
    default=usable_cores,
    show_default=f"the number of cores, up to {DEFAULT_PROCESSES}",
    help="Number of processes.",
)
def main(
    names: tuple[str, ...],
    sets: tuple[str, ...],
    out: Path,
    size: tuple[int, int],
    width_mm: float | None,
    plain: bool,
    form: str,
    design: str,
    flank: str,
    measured: Path | None,
    loaded: Path | None,
    jobs: int,
    **grid: Any,
) -> None:
    """Draw figures, each with its numbers as CSV: the figures of Ni et al. 2017, results such as contact
    pattern and transmission error, and comparisons of the methods."""
    if width_mm is not None and given_options(("size",)):
        raise Refusal(["--size and --width-mm cannot both be given: leave one of them out"])
    layout = of_size(size, plain) if width_mm is None else of_width(width_mm, plain)
    if sum((measured is not None, loaded is not None, bool(names or sets))) > 1:
        raise Refusal(
            ["--measured and --loaded draw a single figure: leave out --only, --set and the other option"]
        )
    if measured is None:
        refuse_without("--measured", grid)
    given = load_design(design)
    note_equal_teeth(given)
    shown: Design | DeviationReport | Loaded = given
    if measured is not None:
        figures, shown = [MEASURED], measured_report(design, given, measured, **grid)
    elif loaded is not None:
        figures, shown = [LOADED], solved_decks(given, click.format_filename(design, shorten=True), loaded)
    else:
        figures = chosen_figures(names, sets)

    from tqdm import tqdm

    if not all(figure.flat for figure in figures):
        require_drawing()
    prepare_folder(out)
    begin = time.perf_counter()
    flanks = ("right", "left") if flank == "both" else (flank,)
    wanted = [
        Job(figure, shown, side, layout, form)
        for figure in figures
        for side in (flanks if figure.of_flank else flanks[:1])
    ]
    done: dict[str, Made] = {}
    with tqdm(total=len(wanted), desc="figures", unit="figure", file=sys.stderr) as bar:
        for job, drawing in made(wanted, jobs):
            with writing(f"{job.name} to {out}"):
                write_figure(job.name, drawing, out)
            done[job.name] = drawing
            bar.set_postfix_str(job.name, refresh=False)
            bar.update()
    where = f"{out.resolve()}, drawn in {time.perf_counter() - begin:.1f} s"
    write_out(summary([(job, done[job.name]) for job in wanted], f"numbers (CSV) are in {where}"))
