"""The command `beveloid-geom tolerance`."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Literal

import click

from ....support.workers import workers
from ... import results
from ...options import (
    NumberRange,
    flank_option,
    option,
    parabola_options,
    progress_bar,
    sizes_of,
    tolerance_options,
)

MOST_CASES, MOST_JOBS = 1_000_000, 1024


OPERATION = "Of so many mountings also the error of all teeth, who carries, where patterns end; slower."
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
    option("--operation", click.IntRange(0, MOST_CASES), 0, OPERATION),
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
    operation: int,
    seed: int,
    jobs: int,
    **tolerances: float,
) -> results.Result:
    """Find paths of contact under drawn assembly errors: how often they leave the flank, how they spread.

    With --operation also what they do in operation: edges, hand-overs, all teeth, and the edges at which
    contact patterns end; some 5 to 10 ms each.
    Errors add to those of the design. Quantiles are those of the mountings with a path on the
    flanks. Exit status 1 if no mounting has one.
    """
    sizes = sizes_of(tolerances, "tolerances")
    from ....analysis.tolerance import RUNNING_COST, Tolerances, tolerance_study
    from ....report.tolerance import ToleranceReport

    given = Tolerances(**sizes, distribution=distribution, sigmas=sigmas)
    with (
        results.refused_values(),
        nullcontext() if jobs == 1 else workers(jobs) as executor,
        progress_bar(cases + RUNNING_COST * operation, "mounting") as bar,
    ):
        study = tolerance_study(
            design,
            given,
            flank,
            cases,
            seed=seed,
            operation=operation,
            executor=executor,
            progress=bar.update,
        )
    return ToleranceReport(name, design, study)
