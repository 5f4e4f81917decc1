"""`render-report`: one page on a design, to be opened in a browser, offline."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from beveloid_geom.cli.commands.contact.tca import FORCE, TORQUE, load_of
from beveloid_geom.cli.options import (
    BUILTIN_DESIGN,
    TOLERANCES,
    NumberRange,
    Refusal,
    changed_design,
    load_design,
    override_options,
    sizes_of,
    tolerance_options,
    write_out,
)
from beveloid_geom.support.whole_file import require_replaceable, whole_file

from ..options import command, option, usable_cores, writing
from .origin import Origin

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from beveloid_geom import Design

    from .data import PageData, Settings

DEFAULT_OUT = Path("outputs/report.html")
SUFFIXES = (".html", ".htm")
WORTH = 8
"""Units of mountings for which a process of their own is worth its start."""


@command("render-report")
@click.argument("design", default=BUILTIN_DESIGN)
@option("--out", click.Path(path_type=Path, dir_okay=False), DEFAULT_OUT, "The page, a single HTML file.")
@override_options
@tolerance_options
@option("--cases", click.IntRange(1, 1_000_000), 20_000, "Mountings drawn.")
@option("--seed", click.IntRange(0), 0, "Of the random numbers.")
@option("--force", NumberRange(0.0, 1e12, min_open=True), None, f"{FORCE}  [default: 1000]", "N")
@option("--torque", NumberRange(0.0, 1e12, min_open=True), None, TORQUE, "NM")
@click.pass_context
def main(
    context: click.Context,
    /,
    design: str,
    out: Path,
    cases: int,
    seed: int,
    force: float | None,
    torque: float | None,
    **values: Any,
) -> None:
    """Write a report on a DESIGN, a TOML file or a built-in name: one HTML page that needs nothing else.

    A verdict with a picture, checks, paths of contact, patterns, ease-off, pressures, transmission error,
    sliding, sensitivity and tolerances of both flanks, and the pair in mesh to be turned in 3D. Without
    tolerances the usual ones are taken. Exit status 1 if neither flank has contact: the page is written and
    says why.
    """
    begin = time.perf_counter()
    own = load_design(design)
    sizes = sizes_of({name: values.pop(name) for name, *_ in TOLERANCES})
    changed, load = changed_design(own, values), load_of(force, torque, None, None)
    settings = settings_of(changed, sizes, cases, seed)
    if load is not None:
        settings = replace(settings, load=load, loaded=True)
    prepare(out)
    origin = Origin(click.format_filename(design), _written(design), changed != own, _now())
    with writing(click.format_filename(out)):
        data, text = _made(origin, changed, settings)
        with whole_file(out) as beside:
            beside.write_text(text, encoding="utf-8", newline="\n")
    size, seconds = out.stat().st_size, time.perf_counter() - begin
    write_out(f"{click.format_filename(out.resolve())}: {size / 1e6:.2f} MB, made in {seconds:.1f} s\n")
    if not data.found:
        for flank, results in data.flanks.items():
            click.echo(f"No contact, {flank} flanks: {results.contact.reason}", err=True)
        context.exit(1)


def prepare(out: Path) -> None:
    """See that the page can be written; its folder is made if it is the usual one, never another."""
    name, folder = click.format_filename(out), Path(os.path.realpath(out)).parent
    try:
        if out == DEFAULT_OUT:
            folder.mkdir(parents=True, exist_ok=True)
        if not folder.is_dir():
            folder_name = click.format_filename(out.parent)
            raise Refusal([f"--out: the folder {folder_name} does not exist: make it first"])
        require_replaceable(out)
        if out.suffix.lower() not in SUFFIXES:
            cure = "name it so, and print it from the browser for a PDF"
            raise Refusal([f"--out: {name} ends in neither .html nor .htm, which the page is: {cure}"])
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise Refusal([f"cannot write {name} ({error.strerror}): choose a file with --out"]) from None


def settings_of(design: Design, sizes: dict[str, float], cases: int, seed: int) -> Settings:
    """Give settings of the tolerance study: `sizes` by their names, mm and rad, the usual ones without any.
    Raises Refusal for those that do not suit the design."""
    from beveloid_geom import Tolerances, tolerance_study
    from beveloid_geom.analysis.tolerance import USUAL_AT

    from .data import Settings

    if not sizes:
        return Settings(USUAL_AT[design.errors_at], False, cases, seed)
    given = Tolerances(**sizes)  # type: ignore[arg-type]  # all are numbers
    try:
        tolerance_study(design, given, cases=1)
    except ValueError as error:
        raise Refusal([str(error)]) from None
    return Settings(given, True, cases, seed)


def _now() -> datetime:
    """Give the time that the page gives; SOURCE_DATE_EPOCH, if it is set, makes the same page of every
    run."""
    return _epoch() or datetime.now(UTC).astimezone()


def _written(design: str) -> datetime | None:
    """Give the time at which the file of a design was last written, or SOURCE_DATE_EPOCH if that is earlier:
    copies made since then are all the same. None for a built-in design."""
    from beveloid_geom.design.file import BUILTINS

    if design in BUILTINS:
        return None
    written, epoch = datetime.fromtimestamp(Path(design).stat().st_mtime, UTC), _epoch()
    return written.astimezone() if epoch is None else min(written, epoch)


def _epoch() -> datetime | None:
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    return None if epoch is None else datetime.fromtimestamp(int(epoch), UTC)


@contextmanager
def _helpers(cases: int) -> Iterator[Executor | None]:
    """Start processes that solve mountings, if there are cores for them and enough of these."""
    from beveloid_geom.analysis.tolerance import UNIT
    from beveloid_geom.support.workers import workers

    number = min(usable_cores() - 1, cases // (WORTH * UNIT))
    if number < 1:
        yield None
        return
    from concurrent.futures.process import BrokenProcessPool

    try:
        with workers(number) as pool:
            yield pool
    except BrokenProcessPool:
        fault = "a process ended before its time, memory may be short: try fewer --cases"
        raise Refusal([fault]) from None


def _made(origin: Origin, design: Design, settings: Settings) -> tuple[PageData, str]:
    """Make the page's data and its text, with a bar of the progress on standard error."""
    from tqdm import tqdm

    from .data import compute

    steps = settings.steps + 2
    with (
        _helpers(settings.cases) as pool,
        tqdm(total=steps, desc="report", unit="step", file=sys.stderr, disable=None) as bar,
    ):

        def progress(stage: str) -> None:
            bar.set_postfix_str(stage)
            bar.update()

        data = compute(origin.name, design, settings, progress, pool)
        progress("charts")
        from .page import draw_charts, page_text

        drawn = draw_charts(data)
        progress("view")
        from .picture import pair_picture
        from .view_data import view_data

        text = page_text(data, drawn, pair_picture(design), view_data(design), origin)
        bar.set_postfix_str("")
    return data, text
