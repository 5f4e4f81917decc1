"""`render-figures`: all figures, the paper's and more, and the numbers behind each."""

from __future__ import annotations

import csv
import os
import re
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from beveloid_geom.cli.options import Refusal, load_design, version_option, write_out
from beveloid_geom.support.whole_file import whole_file

from .figures import FIGURES, Figure

if TYPE_CHECKING:
    from beveloid_geom.design.model import Design

    from .parts.recipe import Table

DEFAULT_OUT = Path("outputs/figures")
SMALLEST, LARGEST = 200, 8000


class NoOpenGL(click.ClickException):
    """Nothing can be drawn on this machine: one line, exit status 3."""

    exit_code = 3


class PageSize(click.ParamType[tuple[int, int]]):
    """A page size in pixels, such as 1600x1200."""

    name = "WxH"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Width and height."""
        match = re.fullmatch(r"(\d+)[xX](\d+)", str(value))
        if not match:
            self.fail(f"{value!r} is not a size: write it as 1600x1200", param, ctx)
        width, height = int(match[1]), int(match[2])
        if not all(SMALLEST <= side <= LARGEST for side in (width, height)):
            self.fail(f"{value!r} is out of range: sides are {SMALLEST} to {LARGEST} pixels", param, ctx)
        return width, height


def chosen_figures(names: Sequence[str]) -> list[Figure]:
    """The figures named, in the paper's order; all of them without names."""
    known = [figure.name for figure in FIGURES]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise Refusal([f"no figure named {', '.join(map(repr, unknown))}: there are {', '.join(known)}"])
    return [figure for figure in FIGURES if not names or figure.name in names]


def prepare_folder(path: Path) -> None:
    """Make the output folder and see that it can be written to."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise Refusal([f"cannot write to {path} ({error.strerror}): choose a folder with --out"]) from None


def write_table(table: Table, path: Path) -> None:
    """Write the numbers behind a figure; the file appears whole or not at all."""
    header, rows = table
    with whole_file(path) as beside, open(beside, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def make_figure(figure: Figure, design: Design, size: tuple[int, int], folder: Path) -> int:
    """Compute, draw and write one figure; the number of its triangles."""
    from .stage import theme

    recipe = figure.recipe()
    data = recipe.compute(design)
    with theme.style():
        drawing = recipe.draw(data, size)
        theme.save_page(drawing.page, folder / f"{figure.name}.png")
    write_table(recipe.rows(data), folder / f"{figure.name}.csv")
    return drawing.triangles


def _list(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not context.resilient_parsing:
        write_out("".join(f"{figure.name}  {figure.title}\n" for figure in FIGURES))
        context.exit()


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@version_option("render-figures")
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
    "--out",
    "folder",
    metavar="DIR",
    type=click.Path(path_type=Path),
    default=DEFAULT_OUT,
    show_default=True,
    help="Folder for PNG and CSV files.",
)
@click.option("--size", type=PageSize(), default="1600x1200", show_default=True, help="Size in pixels.")
@click.option(
    "--design",
    "source",
    metavar="FILE",
    default="ni-2017",
    show_default=True,
    help="Design file (TOML), or the built-in design's name.",
)
def main(names: tuple[str, ...], folder: Path, size: tuple[int, int], source: str) -> None:
    """Draw figures as PNG, each with the numbers behind it as CSV: those of Ni et al. 2017, contact
    pattern, separation, transmission error, and meshes."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its products are too small to be shared out
    figures = chosen_figures(names)
    design = load_design(source)

    from tqdm import tqdm

    from .stage.opengl import MissingOpenGLError, require_opengl

    try:
        require_opengl()
    except MissingOpenGLError as error:
        raise NoOpenGL(str(error)) from None
    prepare_folder(folder)
    summary: list[tuple[Figure, int, float]] = []
    begin = time.perf_counter()
    bar = tqdm(figures, desc="figures", unit="figure", file=sys.stderr)
    for figure in bar:
        bar.set_postfix_str(figure.name)
        start = time.perf_counter()
        try:
            triangles = make_figure(figure, design, size, folder)
        except OSError as error:
            raise Refusal([f"cannot write {figure.name} to {folder} ({error.strerror})"]) from None
        summary.append((figure, triangles, time.perf_counter() - start))
    lines = [
        f"{figure.name}  {triangles:>9,} triangles  {seconds:5.2f} s  {figure.title}"
        for figure, triangles, seconds in summary
    ]
    drawn = "1 figure (PNG) and its" if len(summary) == 1 else f"{len(summary)} figures (PNG) and their"
    seconds = time.perf_counter() - begin
    lines.append(f"{drawn} numbers (CSV) are in {folder.resolve()}, drawn in {seconds:.1f} s")
    write_out("\n".join(lines) + "\n")
