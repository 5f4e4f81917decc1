"""The command `beveloid-geom sensitivity`."""

from __future__ import annotations

import click

from .options import (
    BUILTIN_DESIGN,
    changed_design,
    end_if_jammed,
    flank_option,
    load_design,
    override_options,
    require_one_format,
    write_out,
)


@click.command()
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@override_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON, mm and rad.")
@click.option("--csv", "as_csv", is_flag=True, help="Print CSV, one quantity a row, mm and rad.")
@click.pass_context
def sensitivity(
    context: click.Context, /, design: str, flank: str, as_json: bool, as_csv: bool, **changes: float | None
) -> None:
    """How path, contact ratio, transmission error and backlash answer the assembly errors.

    Derivatives by each of the four errors, exact, at the errors that the design has. Shifts are those of
    the middle of the path, positive towards the heel. Exit status 1 if there is no path on the flanks,
    or the pair cannot be assembled.
    """
    require_one_format(as_json, as_csv)
    changed = changed_design(load_design(design), changes)
    from ..report import sensitivity as report

    found = report.sensitivity_report(click.format_filename(design), changed, flank)
    if as_json:
        write_out(report.sensitivity_json(found))
    else:
        write_out(report.sensitivity_csv(found) if as_csv else report.sensitivity_table(found))
    if found.reason:
        if not as_json:
            click.echo(f"No contact: {found.reason}", err=True)
        context.exit(1)
    end_if_jammed(context, changed, as_json)
