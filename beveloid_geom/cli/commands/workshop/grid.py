"""The command `beveloid-geom grid`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ... import results
from ...options import Refusal, option, parabola_options

if TYPE_CHECKING:
    from ....report.workshop.grid import DeviationReport, GridReport

MEMBER = click.Choice(["pinion", "gear"])
BORDER = "Left free at root, tip, toe and heel: a share as 10%, or mm along profile and face as 2mm."
MEASURED = "File of measured points, in the order and frame of the grid: print their deviations."


def read_border(value: str) -> tuple[str, float, float | None]:
    """Read a border: in words, as a share, and in mm or None. Raises Refusal."""
    match = re.fullmatch(r"\s*([-+.\deE]+)\s*(%|mm)\s*", value)
    try:
        size = float(match[1]) if match else float("nan")
    except ValueError:
        size = float("nan")
    if match is None or size != size:
        raise Refusal([f"--border must be a share as 10% or a length as 2mm, got {value!r}"])
    return f"{size:g} {match[2]}", 0.01 * size, size if match[2] == "mm" else None


grid_options = (
    option("--member", MEMBER, "pinion", "Which gear."),
    option("--rows", int, 5, "Points from root to tip."),
    option("--columns", int, 9, "Points from toe to heel."),
    option("--border", read_border, "10%", BORDER, "SIZE"),
)
"""Which grid is meant."""


def measured_report(
    name: str,
    design: results.Design,
    measured: Path,
    member: str,
    rows: int,
    columns: int,
    border: tuple[str, float, float | None],
) -> DeviationReport:
    """Read the measured points of a grid. Raises Refusal."""
    from ....report.workshop.grid import DeviationReport
    from ....workshop.measured import MeasuredError, read_deviations

    found, file = grid_of(name, design, member, rows, columns, border), click.format_filename(measured)
    try:
        return DeviationReport(found.named, read_deviations(measured, found.grid))
    except MeasuredError as error:
        raise Refusal([f"{file}: {error}"]) from None
    except OSError as error:
        raise Refusal([f"cannot read {file} ({error.strerror or error})"]) from None


def grid_of(
    name: str,
    design: results.Design,
    member: str,
    rows: int,
    columns: int,
    border: tuple[str, float, float | None],
) -> GridReport:
    """Lay the grid that the options ask for. Raises Refusal."""
    from ....report.workshop.grid import GridReport, Named
    from ....workshop.grid import measuring_grid

    words, share, length = border
    with results.refused_values():
        found = measuring_grid(getattr(design, member), rows, columns, share, length)
    return GridReport(Named(name, member, words), found)


@results.result_command(
    *grid_options,
    option("--measured", click.Path(path_type=Path), None, MEASURED, "FILE"),
    parabola_options,
    csv="one point a row",
)
def grid(name: str, design: results.Design, measured: Path | None, **asked: Any) -> results.Result:
    """Give the points and outward normals of a measuring grid on both flanks of a tooth, or read it back.

    As text the neutral table that measuring programs read: what the numbers are, behind #, then a point a
    line. With --measured the deviations of measured points along the normal, with their mean, slopes,
    crowning and twist. A file with a hole, in another order or unit is refused.
    """
    if measured is None:
        return grid_of(name, design, **asked)
    return measured_report(name, design, measured, **asked)
