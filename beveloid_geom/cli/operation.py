"""The command `beveloid-geom operation`."""

from __future__ import annotations

import click

from .options import (
    BUILTIN_DESIGN,
    NumberRange,
    changed_design,
    end_if_jammed,
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
    default=121,
    show_default=True,
    help="Positions over the cycle, both ends included.",
)
@click.option(
    "--harmonics",
    type=click.IntRange(1, 200),
    default=10,
    show_default=True,
    help="Multiples of the mesh frequency.",
)
@click.option(
    "--film",
    type=NumberRange(0.0, 10.0),
    default=0.00635,
    show_default=True,
    metavar="MM",
    help="Clearance up to which a tooth pair counts as touching for the ratio in brackets.",
)
@override_options
@format_options
@click.pass_context
def operation(
    context: click.Context,
    /,
    design: str,
    flank: str,
    points: int,
    harmonics: int,
    film: float,
    as_json: bool,
    as_csv: bool,
    **changes: float | None,
) -> None:
    """Transmission error and contact ratio of a pair in operation.

    At every roll of the pinion the first of all teeth touches, with its flank, its fillet or an
    edge; tooth pairs hand over to each other. One mesh cycle is solved, it repeats with the
    pinion's pitch. Rigid teeth, no load. Exit status 1 if a first contact is not
    known, or the pair cannot be assembled.
    """
    require_one_format(as_json, as_csv)
    changed = changed_design(load_design(design), changes)
    from ..findings.path import first_contact_fault
    from ..report import operation as report

    fault = first_contact_fault(changed)
    if fault:
        raise click.ClickException(f"no first contact: {fault}")  # status 1
    found = report.operation_report(click.format_filename(design), changed, flank, points, harmonics, film)
    if as_json:
        write_out(report.operation_json(found))
    else:
        write_out(report.operation_csv(found) if as_csv else report.operation_table(found))
        if found.reason:
            click.echo(f"No contact: {found.reason}", err=True)
    if found.reason:
        context.exit(1)
    end_if_jammed(context, changed, as_json)
