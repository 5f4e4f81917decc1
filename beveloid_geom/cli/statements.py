"""The command `beveloid-geom statements`."""

from __future__ import annotations

import click

from .options import BUILTIN_DESIGN, load_design, require_one_format, write_out


@click.command()
@click.argument("design", default=BUILTIN_DESIGN)
@click.option(
    "--flank",
    type=click.Choice(["right", "left", "both"]),
    default="both",
    show_default=True,
    help="The paper's figures are of right flanks.",
)
@click.option("--readings", is_flag=True, help="The verdicts alone, under other readings of the paper too.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, mm, deg and rad as each measure says.")
@click.option("--csv", "as_csv", is_flag=True, help="Print CSV, one number a row, or one reading.")
def statements(design: str, flank: str, readings: bool, as_json: bool, as_csv: bool) -> None:
    """Judge the paper's statements on modified flanks and misaligned pairs.

    Each is computed for the DESIGN, whose own parabola coefficients and errors are set aside: holds,
    does not hold, depends on the measure, or not known, with the measures, their numbers and why.
    """
    require_one_format(as_json, as_csv)
    given = load_design(design)
    from ..report import statements as report
    from ..studies.statements import paper_statements

    name = click.format_filename(design)
    flanks = ("right", "left") if flank == "both" else (flank,)
    if readings:
        from ..studies.statement_readings import verdicts_by_reading

        verdicts = {side: verdicts_by_reading(given, side) for side in flanks}
        if as_json:
            write_out(report.readings_json(verdicts))
        else:
            write_out(report.readings_csv(verdicts) if as_csv else report.readings_table(name, verdicts))
        return
    found = [one for side in flanks for one in paper_statements(given, side)]
    if as_json:
        write_out(report.statements_json(found))
    else:
        write_out(report.statements_csv(found) if as_csv else report.statements_table(name, given, found))
