"""The command `beveloid-geom pattern`."""

from __future__ import annotations

import click

from ... import results
from ...options import (
    NumberRange,
    Refusal,
    flank_option,
    no_result,
    option,
    override_options,
    progress_bar,
    refuse_without,
)
from ...tolerance_options import errors_option, given_tolerances, sizes_of, tolerance_names, tolerance_options

POINTS = "Distance between the points on both flanks; the areas do not depend on it.  [default: module / 15]"
ERROR = "Largest relative error of an area; it does not depend on --resolution."
OVER = (
    "Compute patterns under two errors, such as offset,shaft-angle or centre-distance,in-plane, instead of"
    " one pattern. E, Sigma, P and G stand for offset, shaft-angle, pinion-axial and gear-axial."
)
CELLS = click.Choice(["3", "5"])


@results.result_command(
    flank_option,
    option(
        "--separation",
        NumberRange(0.0, 10.0, min_open=True),
        0.00635,
        "Thickness of the marking compound.",
        "MM",
    ),
    option("--resolution", NumberRange(0.01, 100.0), None, POINTS, "MM"),
    option("--area-error", NumberRange(0.001, 0.5), 0.01, ERROR, "SHARE"),
    errors_option("--over", None, OVER),
    option(
        "--cells", CELLS, "3", "Number of values of each error of --over, from minus to plus its tolerance."
    ),
    tolerance_options,
    override_options,
    json=" of areas with their error and extent",
    csv="one point of a flank per row, with --over one flank of a cell",
)
def pattern_command(
    name: str,
    design: results.Design,
    flank: str,
    separation: float,
    resolution: float | None,
    area_error: float,
    over: tuple[str, str] | None,
    cells: str,
    **tolerances: float | None,
) -> results.Result:
    """Compute the contact pattern: the area in which the flanks come within the thickness of marking
    compound.

    One tooth pair rolls from before its contact until after it; the gear is in the position of the first
    contact of all teeth. With --over, a matrix of patterns under two errors is computed, up to the tolerances
    of these errors (if none is given, the usual tolerances of the command `tolerance`). For each
    pattern, the matrix gives the ellipse with the same centre and second moments of area in the side view (z
    against radius r), the transmission error in operation, and the share of the mesh cycle in which edges
    touch. The exit status is 1 if there is no contact or the pair cannot be assembled (with --over: if no
    cell has a pattern), 4 if a first contact could not be computed."""
    from ....analysis.pattern_matrix import pattern_matrix
    from ....findings.path import first_contact_fault
    from ....operation.contact_pattern.motion import UnknownOperationError
    from ....report.pattern import PatternMatrixReport, pattern_report

    if over is None:
        refuse_without("--over", ("cells",))
    sizes = _sizes(over, tolerances)
    if fault := first_contact_fault(design):
        raise no_result(fault, "no pattern")
    if over is None:
        try:
            with results.refused_values():
                return pattern_report(name, design, flank, separation, resolution, area_error)
        except UnknownOperationError as error:
            raise no_result(error.reason, "no pattern") from None
    options, count = tolerance_names("the size of the error of"), int(cells)
    with results.refused_values(options), progress_bar(count**2, "cell") as bar:
        matrix = pattern_matrix(
            design,
            over,
            flank,
            sizes=sizes,
            cells=count,
            separation=separation,
            resolution=resolution,
            area_error=area_error,
            progress=bar.update,
        )
    return PatternMatrixReport(name, design, matrix)


def _sizes(over: tuple[str, str] | None, tolerances: dict[str, float | None]) -> tuple[float, float] | None:
    """Return the sizes of both errors, mm or rad, None if none is given. Raises Refusal for tolerances of
    other errors, or of only one error."""
    given = given_tolerances(tolerances)
    if not given:
        return None
    if over is None:
        raise Refusal([f"{next(iter(given.values()))} is for patterns under two errors: add --over"])
    if others := [option for name, option in given.items() if name not in over]:
        raise Refusal(
            [f"{others[0]} is for an error that is not in --over: add the error, or omit the option"]
        )
    if len(given) < len(over):
        cure = "give the tolerances of both errors in --over, or none"
        raise Refusal([f"{next(iter(given.values()))} is the only tolerance: {cure}"])
    values = sizes_of(tolerances)
    return values.get(over[0], 0.0), values.get(over[1], 0.0)
