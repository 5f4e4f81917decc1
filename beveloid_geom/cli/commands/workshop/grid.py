"""The command `beveloid-geom grid`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ... import results
from ...options import Refusal, option, tooth_options

if TYPE_CHECKING:
    from ....report.workshop.grid import DeviationReport, GridReport


def read_border(value: str) -> tuple[str, float, float | None]:
    """Return a border as text, as a share, and in mm or None. Raises Refusal."""
    from ....workshop.grid import border_of

    try:
        return border_of(value)
    except ValueError as error:
        raise Refusal([f"--{error}"]) from None


grid_options = (
    option("--member", click.Choice(["pinion", "gear"]), "pinion", "Member of the pair."),
    option("--rows", int, 5, "Points from root to tip."),
    option("--columns", int, 9, "Points along the face, from -z to +z."),
    option(
        "--border",
        read_border,
        "10%",
        "Margin at root, tip and both ends of the face: a share such as 10%, or a length such as 2mm.",
        "SIZE",
    ),
)
"""Options that define the grid."""


def measured_report(name: str, design: results.Design, measured: Path, **options: Any) -> DeviationReport:
    """Return the deviations of measured points on a grid, whose options are those of `nominal_grid`. Raises
    Refusal."""
    from ....report.workshop.grid import DeviationReport
    from ....workshop.measured import MeasuredError, read_deviations

    nominal, file = nominal_grid(name, design, **options), click.format_filename(measured)
    try:
        return DeviationReport(nominal.named, read_deviations(measured, nominal.grid))
    except MeasuredError as error:
        raise Refusal([f"{file}: {error}"]) from None
    except OSError as error:
        cure = "give the path of a file of measured points"
        raise Refusal([f"cannot read {file} ({error.strerror or error}): {cure}"]) from None


def nominal_grid(
    name: str,
    design: results.Design,
    member: str,
    rows: int,
    columns: int,
    border: tuple[str, float, float | None],
) -> GridReport:
    """Return the nominal grid of the options. Raises Refusal."""
    from ....report.workshop.grid import GridOrigin, GridReport
    from ....workshop.grid import measuring_grid

    words, share, length = border
    with results.refused_values():
        points = measuring_grid(getattr(design, member), rows, columns, share, length)
    return GridReport(GridOrigin(name, member, words), points)


@results.result_command(
    *grid_options,
    option(
        "--measured",
        click.Path(path_type=Path),
        None,
        "File of measured points, in the order and frame of the grid; their deviations are printed.",
        "FILE",
    ),
    tooth_options,
    csv="one point per row",
)
def grid(name: str, design: results.Design, measured: Path | None, **options: Any) -> results.Result:
    """Compute the points and outward normals of a measuring grid on both flanks of a tooth, or evaluate
    measured points.

    The text is a table for measuring programs. Lines that begin with # contain definitions; the others
    contain one point each. With --measured, the deviations of measured points along the normal are printed,
    with their mean, slopes, crowning and twist. A file with missing points, or in another order or unit, is
    rejected."""
    if measured is None:
        return nominal_grid(name, design, **options)
    return measured_report(name, design, measured, **options)
