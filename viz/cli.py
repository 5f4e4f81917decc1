"""`render-figures`: all figures, the paper's and more, and the numbers behind each."""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from beveloid_geom.cli.options import BUILTIN_DESIGN, Refusal, load_design, write_out
from beveloid_geom.support.whole_file import whole_file

from .figures import FIGURES, Figure
from .options import command, option, prepare_folder, require_drawing, size_option, writing

if TYPE_CHECKING:
    from beveloid_geom import Design

    from .parts.recipe import Table

DEFAULT_OUT = Path("outputs/figures")


def chosen_figures(names: Sequence[str]) -> list[Figure]:
    """Give the figures named, in the paper's order; all of them without names."""
    known = [figure.name for figure in FIGURES]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise Refusal([f"no figure named {', '.join(map(repr, unknown))}: there are {', '.join(known)}"])
    return [figure for figure in FIGURES if not names or figure.name in names]


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
@option("--out", click.Path(path_type=Path), DEFAULT_OUT, "Folder for PNG and CSV files.", metavar="DIR")
@size_option("1600x1200")
@option("--design", str, BUILTIN_DESIGN, "Design file (TOML), or the built-in design's name.", metavar="FILE")
def main(names: tuple[str, ...], out: Path, size: tuple[int, int], design: str) -> None:
    """Draw figures as PNG, each with the numbers behind it as CSV: those of Ni et al. 2017, contact
    pattern, separation, transmission error, and meshes."""
    figures = chosen_figures(names)
    loaded = load_design(design)

    from tqdm import tqdm

    require_drawing()
    prepare_folder(out)
    lines: list[str] = []
    begin = time.perf_counter()
    bar = tqdm(figures, desc="figures", unit="figure", file=sys.stderr)
    for figure in bar:
        bar.set_postfix_str(figure.name)
        start = time.perf_counter()
        with writing(f"{figure.name} to {out}"):
            triangles = make_figure(figure, loaded, size, out)
        seconds = time.perf_counter() - start
        lines.append(f"{figure.name}  {triangles:>9,} triangles  {seconds:5.2f} s  {figure.title}")
    drawn = "1 figure (PNG) and its" if len(lines) == 1 else f"{len(lines)} figures (PNG) and their"
    seconds = time.perf_counter() - begin
    lines.append(f"{drawn} numbers (CSV) are in {out.resolve()}, drawn in {seconds:.1f} s")
    write_out("\n".join(lines) + "\n")
