"""The command `beveloid-geom tolerance`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import TYPE_CHECKING, Any, Literal

import click

from ...support.process import undoing
from .. import results
from ..options import (
    NumberRange,
    flank_option,
    option,
    parabola_options,
    progress_bar,
    sizes_of,
    tolerance_options,
)

if TYPE_CHECKING:
    from concurrent.futures import Executor


MOST_CASES, MOST_JOBS = 1_000_000, 1024


SPREADS = click.Choice(["normal", "uniform"])


@results.result_command(
    flank_option,
    tolerance_options,
    option("--distribution", SPREADS, SPREADS.choices[0], "Of each error."),
    option(
        "--sigmas",
        NumberRange(0.0, 100.0, min_open=True),
        3.0,
        "Standard deviations in a tolerance, if normal.",
    ),
    option("--cases", click.IntRange(1, MOST_CASES), 100_000, "Mountings drawn."),
    option("--seed", click.IntRange(0), 0, "Of the random numbers."),
    option("--jobs", click.IntRange(1, MOST_JOBS), 1, "Processes; their number does not change the result."),
    parabola_options,
    json=" of the summary",
    csv="one mounting a row",
)
def tolerance(
    name: str,
    design: results.Design,
    flank: str,
    distribution: Literal["normal", "uniform"],
    sigmas: float,
    cases: int,
    seed: int,
    jobs: int,
    **tolerances: float,
) -> results.Result:
    """Find paths of contact under drawn assembly errors: how often they leave the flank, how they spread.

    Errors add to those of the design. Quantiles are those of the mountings with a path on the
    flanks. Exit status 1 if no mounting has one.
    """
    sizes = sizes_of(tolerances, "tolerances")
    from ...analysis.tolerance import Tolerances, tolerance_study
    from ...report.tolerance import ToleranceReport

    given = Tolerances(*sizes, distribution, sigmas)
    with (
        results.refused_values(),
        nullcontext() if jobs == 1 else workers(jobs) as executor,
        progress_bar(cases, "mounting") as bar,
    ):
        study = tolerance_study(
            design, given, flank, cases, seed=seed, executor=executor, progress=bar.update
        )
    return ToleranceReport(name, design, study)


@contextmanager
def workers(number: int) -> Iterator[Executor]:
    """Start fresh processes, as on all systems. Signals are the parent's business from their first moment."""
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
