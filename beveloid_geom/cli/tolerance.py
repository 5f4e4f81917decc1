"""The command `beveloid-geom tolerance`."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from ..support.process import undoing
from .options import (
    BUILTIN_DESIGN,
    NumberRange,
    Refusal,
    changed_design,
    error_sizes,
    flank_option,
    load_design,
    parabola_options,
    require_one_format,
    require_sizes,
    write_out,
)

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from ..analysis.tolerance import Distribution, Tolerances, ToleranceStudy
    from ..design.model import Design

MOST_CASES, MOST_JOBS = 1_000_000, 1024


@click.command()
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@error_sizes("Tolerance")
@click.option("--distribution", type=click.Choice(["normal", "uniform"]), default="normal", show_default=True)
@click.option(
    "--sigmas",
    type=NumberRange(0.0, 100.0, min_open=True),
    default=3.0,
    show_default=True,
    help="Standard deviations in a tolerance, if normal.",
)
@click.option(
    "--cases", type=click.IntRange(1, MOST_CASES), default=100_000, show_default=True, help="Mountings drawn."
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the random numbers.")
@click.option(
    "--jobs",
    type=click.IntRange(1, MOST_JOBS),
    default=1,
    show_default=True,
    help="Processes; their number does not change the result.",
)
@parabola_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON of the summary, mm and rad.")
@click.option("--csv", "as_csv", is_flag=True, help="Print CSV, one mounting a row, mm and rad.")
@click.pass_context
def tolerance(
    context: click.Context,
    /,
    design: str,
    flank: str,
    offset: float,
    shaft_angle_deg: float,
    pinion_axial: float,
    gear_axial: float,
    distribution: str,
    sigmas: float,
    cases: int,
    seed: int,
    jobs: int,
    as_json: bool,
    as_csv: bool,
    **changes: float | None,
) -> None:
    """Paths of contact under drawn assembly errors: how often they leave the flank, how they spread.

    Errors add to those of the design. Quantiles are those of the mountings with a path on the
    flanks. Exit status 1 if no mounting has one.
    """
    require_one_format(as_json, as_csv)
    require_sizes("tolerances", (offset, shaft_angle_deg, pinion_axial, gear_axial))
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its products are too small to be shared out
    changed = changed_design(load_design(design), changes)
    from ..analysis.tolerance import Tolerances
    from ..report import tolerance as report

    angle = math.radians(shaft_angle_deg)
    spread: Distribution = "uniform" if distribution == "uniform" else "normal"
    given = Tolerances(offset, angle, pinion_axial, gear_axial, spread, sigmas)
    try:
        study = _study(changed, given, flank, cases, seed, jobs)
    except ValueError as error:
        raise Refusal([str(error)]) from None
    name = click.format_filename(design)
    if as_json:
        write_out(report.tolerance_json(name, changed, study))
    else:
        write_out(report.tolerance_csv(study) if as_csv else report.tolerance_table(name, changed, study))
    if not study.mountings.solved.any():
        click.echo(f"No contact: no mounting has a path on the {flank} flanks", err=True)
        context.exit(1)


def _study(
    design: Design, tolerances: Tolerances, flank: str, cases: int, seed: int, jobs: int
) -> ToleranceStudy:
    """The study with a bar of its progress on standard error, if that is a terminal."""
    from contextlib import nullcontext

    from tqdm import tqdm

    from ..analysis.tolerance import tolerance_study

    with (
        nullcontext() if jobs == 1 else workers(jobs) as executor,
        tqdm(total=cases, desc="mountings", unit="mounting", file=sys.stderr, disable=None) as bar,
    ):
        return tolerance_study(
            design, tolerances, flank, cases, seed=seed, executor=executor, progress=bar.update
        )


@contextmanager
def workers(number: int) -> Iterator[Executor]:
    """Fresh processes, as on all systems. Signals are the parent's business from their first moment."""
    import multiprocessing
    import signal
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import resource_tracker, util

    untyped: Any = util

    def ended() -> str:
        for child in multiprocessing.active_children():
            child.kill()
        untyped._run_finalizers(0)  # or the tracker of resources complains of semaphores that are left
        return ""

    context, unheard = multiprocessing.get_context("spawn"), (signal.SIGINT, signal.SIG_IGN)
    with undoing(ended), ProcessPoolExecutor(number, context, signal.signal, unheard) as pool:
        if hasattr(signal, "pthread_sigmask"):  # what is blocked here stays so in the processes started
            resource_tracker.ensure_running()  # it would end the blocking
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        for _ in range(number):  # each starts a process, as none is idle so soon
            pool.submit(int)
        if hasattr(signal, "pthread_sigmask"):
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        yield pool
