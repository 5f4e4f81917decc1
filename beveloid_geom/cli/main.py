"""The command `beveloid-geom`.

Exit status: 0 done (`check`: errors, warnings or not), 1 no contact on the flanks, none that could be
followed, or a pair that cannot be assembled, 2 bad input; `process` has those of a command that does
not come to its end.
"""

from __future__ import annotations

import click

from .map import map_command
from .mesh import mesh
from .operation import operation
from .optimise import optimise
from .options import (
    BUILTIN_DESIGN,
    changed_design,
    end_if_jammed,
    flank_option,
    format_options,
    load_design,
    override_options,
    parabola_options,
    require_one_format,
    version_option,
    write_out,
)
from .pattern import pattern
from .sensitivity import sensitivity
from .sliding import sliding
from .statements import statements
from .tolerance import tolerance


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@version_option("beveloid-geom")
def main() -> None:
    """Tooth contact analysis of crossed beveloid gears with parabolic profile modification.

    A DESIGN is a TOML file or the name of the built-in design, ni-2017.
    """


@main.command()
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@click.option(
    "--points",
    type=click.IntRange(2, 100_000),
    default=101,
    show_default=True,
    help="Positions along the path, both ends included.",
)
@override_options
@click.option(
    "--method",
    type=click.Choice(["one-equation", "five-equation"]),
    default="one-equation",
    show_default=True,
    help="The five equations are the paper's, slower, to compare with.",
)
@click.option(
    "--certify/--no-certify",
    default=True,
    show_default=True,
    help="Whether anything else of the teeth touches earlier, about a millisecond a position.",
)
@format_options
@click.pass_context
def tca(
    context: click.Context,
    /,
    design: str,
    flank: str,
    points: int,
    method: str,
    certify: bool,
    as_json: bool,
    as_csv: bool,
    **changes: float | None,
) -> None:
    """Tooth contact analysis: path of contact of a pair of flanks.

    Rolls count from the position in which each member's generating rack is centred; z counts
    from mid-face towards the heel. JSON and CSV give each position a status, and JSON the path:
    solved, no_common_normal, not_converged, off_flank, several_contacts, endless or undefined.
    Exit status 1 if there is no contact on the flanks, or the pair cannot be assembled.
    """
    require_one_format(as_json, as_csv)
    changed = changed_design(load_design(design), changes)
    from ..report import path as report

    try:
        found = report.contact_report(click.format_filename(design), changed, flank, points, method, certify)
    except ArithmeticError as error:
        raise click.ClickException(str(error)) from None  # status 1: nothing wrong with the input
    if as_json:
        write_out(report.contact_json(found))
    else:
        write_out(report.contact_csv(found) if as_csv else report.contact_table(found))
        if found.reason:
            click.echo(f"No contact: {found.reason}", err=True)
    if found.reason:
        context.exit(1)
    end_if_jammed(context, changed, as_json)


@main.command()
def design() -> None:
    """Print the built-in design file, as a start for one's own."""
    from ..design.file import builtin_text

    write_out(builtin_text())


@main.command()
@click.argument("design", default=BUILTIN_DESIGN)
@parabola_options
@click.option("--json", "as_json", is_flag=True, help="Print JSON, mm and rad.")
@click.option("--csv", "as_csv", is_flag=True, help="Print CSV, one quantity a row, mm and rad.")
def check(design: str, as_json: bool, as_csv: bool, **changes: float | None) -> None:
    """Say whether a design meshes and how well it closes: offset, shaft angle, backlash.

    Errors: gears that do not reach each other or run into each other, no contact on a flank, a pair
    that cannot be assembled as mounted; with advice that was tried first. Warnings: lines of action that
    do not meet, contact that usual errors of assembly lose, edges that touch earlier, undercut, pointed
    teeth, tools whose rounds overlap. Exit status 0 with or without them.
    """
    require_one_format(as_json, as_csv)
    given = changed_design(load_design(design), changes)
    from ..report import closing as report

    found = report.closing_report(click.format_filename(design), given)
    if as_json:
        write_out(report.closing_json(found))
    else:
        write_out(report.closing_csv(found) if as_csv else report.closing_table(found))


main.add_command(mesh)
main.add_command(map_command)
main.add_command(operation)
main.add_command(pattern)
main.add_command(statements)
main.add_command(sensitivity)
main.add_command(sliding)
main.add_command(optimise)
main.add_command(tolerance)
