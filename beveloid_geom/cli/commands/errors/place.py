"""The command `beveloid-geom place`."""

from __future__ import annotations

import click

from ... import results
from ...options import NumberRange, errors_option, flank_option, option, override_options

AT = "Where on the pinion's face the middle of the path is wanted, from the toe; may be repeated."
BY = "The two errors: offset,shaft-angle, or axial ones, which change mounting distances."
L1 = "Where on the pinion's profile, in place of its centre."


@results.result_command(
    click.option(
        "--at",
        type=NumberRange(0.0, 100.0, min_open=True, max_open=True),
        multiple=True,
        default=(25.0, 50.0, 75.0),
        show_default=True,
        metavar="PERCENT",
        help=AT,
    ),
    errors_option("--by", "offset,shaft-angle", BY),
    option("--l1", float, None, L1, "MM"),
    flank_option,
    override_options,
    csv="one place a row",
)
def place(
    name: str,
    design: results.Design,
    at: tuple[float, ...],
    by: tuple[str, str],
    l1: float | None,
    flank: str,
) -> results.Result:
    """Find two errors that put the middle of the path at shares of the face, centred in profile.

    To 1e-6 mm, and solved anew under what was found. Errors are by their names or by the letters of the
    trade: E offset, Sigma shaft angle, P and G pinion and gear axial. What cannot be reached is said with the
    nearest that can. Some seconds. Exit status 1 if no mounting has a path, or a first contact is not known.
    """
    from ....findings.path import first_contact_fault
    from ....report.aims import place_report

    if fault := first_contact_fault(design):
        raise click.ClickException(f"no first contact: {fault}")  # status 1
    with results.refused_values():
        return place_report(name, design, tuple(share / 100.0 for share in at), by, flank, l1)
