"""The command `beveloid-geom sensitivity`."""

from __future__ import annotations

import click

from .cli_support import (
    BUILTIN_DESIGN,
    changed_design,
    flank_option,
    load_design,
    override_options,
    write_out,
)


@click.command()
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@override_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON, mm and rad.")
@click.pass_context
def sensitivity(
    context: click.Context, /, design: str, flank: str, as_json: bool, **changes: float | None
) -> None:
    """How path, contact ratio and transmission error answer the assembly errors.

    Derivatives by each of the four errors, exact, at the errors that the design has. Shifts are those of
    the middle of the path, positive towards the heel. Exit status 1 if there is no path on the flanks.
    """
    changed = changed_design(load_design(design), changes)
    from . import report_sensitivity as report

    found = report.sensitivity_report(click.format_filename(design), changed, flank)
    write_out(report.sensitivity_json(found) if as_json else report.sensitivity_table(found))
    if found.reason:
        if not as_json:
            click.echo(f"No contact: {found.reason}", err=True)
        context.exit(1)
