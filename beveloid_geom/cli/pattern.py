"""The command `beveloid-geom pattern`."""

from __future__ import annotations

import click

from .options import (
    BUILTIN_DESIGN,
    NumberRange,
    Refusal,
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
@click.option(
    "--separation",
    type=NumberRange(0.0, 10.0, min_open=True),
    default=0.00635,
    show_default=True,
    metavar="MM",
    help="Thickness of the marking compound.",
)
@click.option(
    "--resolution",
    type=NumberRange(0.01, 100.0),
    metavar="MM",
    help="Distance of the points on both flanks. Default: a fifteenth of the module. No areas hang on it.",
)
@click.option(
    "--area-error",
    type=NumberRange(0.001, 0.5),
    default=0.01,
    show_default=True,
    metavar="SHARE",
    help="Greatest error of an area, as a share of it, whatever the distance of the points.",
)
@override_options
@click.option(
    "--json", "as_json", is_flag=True, help="Print JSON of areas with their error and extent, mm and rad."
)
@click.option("--csv", "as_csv", is_flag=True, help="Print CSV, one point of a flank a row, mm and rad.")
@click.pass_context
def pattern(
    context: click.Context,
    /,
    design: str,
    flank: str,
    separation: float,
    resolution: float | None,
    area_error: float,
    as_json: bool,
    as_csv: bool,
    **changes: float | None,
) -> None:
    """Contact pattern: where the flanks come within marking compound of each other.

    One tooth pair rolls through the mesh, the gear where the first of all teeth touches. Exit status 1
    if a first contact is not known, or the pair cannot be assembled.
    """
    require_one_format(as_json, as_csv)
    changed = changed_design(load_design(design), changes)
    from ..findings.path import first_contact_fault
    from ..operation.operating_rolls import UnknownOperationError
    from ..report import pattern as report

    fault = first_contact_fault(changed)
    if fault:
        raise click.ClickException(f"no pattern: {fault}")  # status 1
    try:
        name = click.format_filename(design)
        found = report.pattern_report(name, changed, flank, separation, resolution, area_error)
    except UnknownOperationError as error:
        raise click.ClickException(f"no pattern: {str(error).partition(': give')[0]}") from None  # status 1
    except ValueError as error:
        raise Refusal([str(error)]) from None
    if as_json:
        write_out(report.pattern_json(found))
    else:
        write_out(report.pattern_csv(found) if as_csv else report.pattern_table(found))
    end_if_jammed(context, changed, as_json)
