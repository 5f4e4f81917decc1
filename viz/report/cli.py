"""`render-report`: one page about a design for the browser, without network access."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from beveloid_geom.cli.commands.contact.tca import FORCE, TORQUE, load_of
from beveloid_geom.cli.options import (
    BUILTIN_DESIGN,
    NumberRange,
    Refusal,
    changed_design,
    load_design,
    note_equal_teeth,
    override_options,
    worker_processes,
    write_out,
)
from beveloid_geom.cli.results import refused_values, require_folder
from beveloid_geom.cli.tolerance_options import TOLERANCES, sizes_of, tolerance_names, tolerance_options
from beveloid_geom.support.atomic_file import atomic_file, replaceable_mode
from beveloid_geom.support.process import source_date

from ..options import command, option, usable_cores, writing
from .origin import Origin, design_options, tolerances_of

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from beveloid_geom import Design

    from .data import PageData, ReportSettings

DEFAULT_OUT = Path("outputs/report.html")


@command("render-report")
@click.argument("design", default=BUILTIN_DESIGN)
@option("--out", click.Path(path_type=Path, dir_okay=False), DEFAULT_OUT, "File to write, .html or .htm.")
@override_options
@tolerance_options
@option("--cases", click.IntRange(1, 1_000_000), 20_000, "Number of mountings with random errors.")
@option("--seed", click.IntRange(0), 0, "Seed of the random errors.")
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
    """Write a report on a DESIGN, a TOML file or a built-in name: one HTML page without external files.

    The page has a verdict with a picture, checks, and for both flanks: path of contact, pattern, ease-off,
    pressure, transmission error, sliding, sensitivity and tolerances, and a 3D view of the pair in mesh.
    If no tolerance is given, the usual tolerances of `beveloid-geom tolerance` are used. The
    exit status is 1 if neither flank has contact or the pair cannot be assembled, 4 if contact or
    operation of a flank pair could not be computed. The page is written in all cases and gives the reason.
    """
    begin = time.perf_counter()
    tolerances = {name: values.pop(name) for name, *_ in TOLERANCES}
    sizes = sizes_of(tolerances)
    changed, load = changed_design(load_design(design), values), load_of(force, torque, None, None)
    note_equal_teeth(changed)
    settings = settings_of(changed, sizes, cases, seed)
    if load is not None:
        settings = replace(settings, load=load, loaded=True)
    prepare(out)
    # Every run writes the same page if SOURCE_DATE_EPOCH is set.
    made, study = source_date() or datetime.now(UTC).astimezone(), tolerances_of(tolerances, cases, seed)
    origin = Origin(click.format_filename(design), _written(design), made, design_options(values), study)
    with writing(click.format_filename(out)):
        data, text = _made(origin, changed, settings)
        with atomic_file(out) as part:
            part.write_text(text, encoding="utf-8", newline="\n")
    size, seconds = out.stat().st_size, time.perf_counter() - begin
    write_out(f"{click.format_filename(out.resolve())}: {size / 1e6:.2f} MB, made in {seconds:.1f} s\n")
    for failure in data.failures:
        click.echo(failure.text, err=True)
    if data.failures:
        context.exit(max(failure.status for failure in data.failures))


def prepare(out: Path) -> None:
    """Check that the page can be written. Only the default folder is created."""
    suffixes = (".html", ".htm")
    name, folder = click.format_filename(out), Path(os.path.realpath(out)).parent
    try:
        if out == DEFAULT_OUT:
            folder.mkdir(parents=True, exist_ok=True)
        require_folder(out)
        replaceable_mode(out)
        if out.suffix.lower() not in suffixes:
            cure = "choose such a name; for a PDF, print the page from the browser"
            raise Refusal([f"--out: {name} ends in neither .html nor .htm: {cure}"])
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise Refusal([f"cannot write {name} ({error.strerror}): choose a file with --out"]) from None


def settings_of(design: Design, sizes: dict[str, float], cases: int, seed: int) -> ReportSettings:
    """Return the settings of the tolerance study; without sizes (mm, rad, by name), the usual ones. Raises
    Refusal for tolerances that do not suit the design."""
    from beveloid_geom import Tolerances, tolerance_study
    from beveloid_geom.analysis.tolerance import USUAL_AT

    from .data import ReportSettings

    if not sizes:
        return ReportSettings(USUAL_AT[design.errors_at], False, cases, seed)
    given = Tolerances(**sizes)  # type: ignore[arg-type]  # all are numbers
    with refused_values(tolerance_names("tolerance of")):
        tolerance_study(design, given, cases=1)
    return ReportSettings(given, True, cases, seed)


def _written(design: str) -> datetime | None:
    """Return the time at which a design file was last written, or SOURCE_DATE_EPOCH if earlier, so that later
    copies give the same page. None for a built-in design."""
    from beveloid_geom.design.file import BUILTINS

    if design in BUILTINS:
        return None
    written, epoch = datetime.fromtimestamp(Path(design).stat().st_mtime, UTC), source_date()
    return written.astimezone() if epoch is None else min(written, epoch)


def _helpers(cases: int) -> AbstractContextManager[Executor | None]:
    """Start processes for the mountings if there are free cores and enough mountings."""
    # Number of blocks of mountings from which an additional process is worth its start.
    worth = 8
    from beveloid_geom.analysis.tolerance import MOUNTINGS_PER_BLOCK

    number = min(usable_cores() - 1, cases // (worth * MOUNTINGS_PER_BLOCK))
    return worker_processes(number, "try fewer --cases") if number >= 1 else nullcontext()


def _made(origin: Origin, design: Design, settings: ReportSettings) -> tuple[PageData, str]:
    """Return data and text of the page, with a progress bar on standard error."""
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
