"""The command `beveloid-geom place`."""

from __future__ import annotations

import click

from ... import results
from ...options import NumberRange, flank_option, no_result, option, override_options
from ...tolerance_options import errors_option


@results.result_command(
    click.option(
        "--at",
        type=NumberRange(0.0, 100.0, min_open=True, max_open=True),
        multiple=True,
        default=(25.0, 50.0, 75.0),
        show_default=True,
        metavar="PERCENT",
        help="Position of the middle of the path on the pinion face, from the end at -z; can be repeated.",
    ),
    errors_option(
        "--by",
        "offset,shaft-angle",
        "Two errors, such as offset,shaft-angle; axial errors change mounting distances.",
    ),
    option(
        "--l1",
        float,
        None,
        "l1 of the middle of the path: position along the pinion's tool flank from the apex of its parabola"
        " towards the tip. Default: centred in profile.",
        "MM",
    ),
    flank_option,
    override_options,
    csv="one position per row",
)
def place_command(
    name: str,
    design: results.Design,
    at: tuple[float, ...],
    by: tuple[str, str],
    l1: float | None,
    flank: str,
) -> results.Result:
    """Compute two errors that move the middle of the path to given positions on the face, centred in profile.

    The positions are reached to 1e-6 mm; this is checked by solving the contact with the computed errors.
    Errors are named by words or by symbols: E (offset), Sigma (shaft angle), P and G (axial errors of pinion
    and gear). If the pair jams at a position, the nearest position in profile at which it can be assembled is
    printed. The calculation takes some seconds. The exit status is 1 if no position has values because no
    mounting has a path or the pair jams at all of them, 4 if no position has values because the search did
    not converge, or if first contacts could not be computed."""
    from ....findings.path import first_contact_fault
    from ....report.placement import place_report

    if fault := first_contact_fault(design):
        raise no_result(fault)
    with results.refused_values({"l": "--l1"}):
        return place_report(name, design, tuple(share / 100.0 for share in at), by, flank, l1)
