"""The command `beveloid-geom tolerance`."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Literal

import click

from ... import results
from ...options import (
    NumberRange,
    flank_option,
    option,
    progress_bar,
    refuse_without,
    tooth_options,
    worker_processes,
)
from ...tolerance_options import sizes_of, tolerance_names, tolerance_options

MAX_CASES = 1_000_000


@results.result_command(
    flank_option,
    tolerance_options,
    option("--distribution", click.Choice(["normal", "uniform"]), "normal", "Distribution of each error."),
    option(
        "--sigmas",
        NumberRange(0.0, 100.0, min_open=True),
        3.0,
        "Number of standard deviations that equal a tolerance, for the normal distribution.",
    ),
    option("--cases", click.IntRange(1, MAX_CASES), 100_000, "Number of random mountings."),
    option(
        "--operation",
        click.IntRange(0, MAX_CASES),
        0,
        "Number of mountings, the first ones, for which the mesh cycle is computed as well. Patterns are"
        " computed for the 24 of them that move the path furthest along the face.",
    ),
    option("--seed", click.IntRange(0), 0, "Seed of the random numbers."),
    option(
        "--jobs",
        click.IntRange(1, 1024),
        1,
        "Largest number of processes. At most one is started for each 4096 mountings, or for each 64"
        " mountings of --operation. The result does not depend on it.",
    ),
    tooth_options,
    json=" of the summary",
    csv="one mounting per row",
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
    **tolerances: float | None,
) -> results.Result:
    """Monte Carlo study of the path of contact under random assembly errors.

    With --operation the mesh cycle is computed as well: edge contact, transmission error of all teeth, a
    contact ratio that counts tooth pairs with clearances up to 6.35 um, and the edges at which contact
    patterns end. This takes about 5 to 10 ms per mounting. The errors are added to the errors of the design.
    If no tolerance is given, the usual tolerances are used: 0.05 mm of offset, 0.01 deg of
    shaft angle, and 0.1 mm of each axial position. For a design with errors at the mesh they are 0.05 mm of
    centre distance, 0.01 deg in plane and out of plane, and 0.1 mm of each axial position. Quantiles are
    computed from the mountings with a path on the flanks. The exit status is 1 if no mounting has a path, or
    if the design cannot be assembled, 4 if no path was found and not all could be computed."""
    if distribution != "normal":
        refuse_without("--distribution normal", ("sigmas",))
    sizes = sizes_of(tolerances, design)
    from ....analysis.tolerance import CYCLE_COST_PATHS, Tolerances, tolerance_study, useful_processes
    from ....report.tolerance import ToleranceReport

    processes = min(jobs, useful_processes(cases, operation))
    given = Tolerances(**sizes, distribution=distribution, sigmas=sigmas)
    with (
        results.refused_values(tolerance_names("tolerance of")),
        nullcontext() if processes == 1 else worker_processes(processes, "try fewer --jobs") as executor,
        progress_bar(cases + CYCLE_COST_PATHS * operation, "mounting") as bar,
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
