"""The command `beveloid-geom sliding`."""

from __future__ import annotations

import click

from .options import (
    BUILTIN_DESIGN,
    changed_design,
    flank_option,
    format_options,
    load_design,
    override_options,
    require_one_format,
    write_out,
)


@click.command()
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@click.option(
    "--points",
    type=click.IntRange(2, 100_000),
    default=21,
    show_default=True,
    help="Positions along the path, both ends included.",
)
@override_options
@format_options
@click.pass_context
def sliding(
    context: click.Context,
    /,
    design: str,
    flank: str,
    points: int,
    as_json: bool,
    as_csv: bool,
    **changes: float | None,
) -> None:
    """Sliding speed and specific sliding along the path of contact.

    Speeds are in mm per rad of the pinion's roll: times its speed in rad/s they are in mm/s. Specific
    sliding is that along each member's profile; the total counts sliding in all directions, per
    distance that the contact runs over the member's flank. Exit status 1 without contact.
    """
    require_one_format(as_json, as_csv)
    changed = changed_design(load_design(design), changes)
    from ..report import sliding as report

    found = report.sliding_report(click.format_filename(design), changed, flank, points)
    if as_json:
        write_out(report.sliding_json(found))
    else:
        write_out(report.sliding_csv(found) if as_csv else report.sliding_table(found))
        if found.reason:
            click.echo(f"No contact: {found.reason}", err=True)
    if found.reason:
        context.exit(1)
