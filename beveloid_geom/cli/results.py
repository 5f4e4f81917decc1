"""Commands that print a result: what they do alike is done here.

A new one is one module on a shelf of `commands`, with a function of a name, a design and its options:

    @results.result_command(flank_option, override_options, csv="one position a row")
    def mine(name: str, design: results.Design, flank: str) -> results.Result:
        '''One sentence that the list of commands shows.'''
        from ....report.mine import my_report

        return my_report(name, design, flank)
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from .options import BUILTIN_DESIGN, OVERRIDES, Option, Refusal, block, changed_design, load_design, write_out

if TYPE_CHECKING:  # what commands take and give: nothing reads their annotations while they run
    from ..design.model import Design as Design
    from ..report.result import Result as Result


def named(function: Callable[..., Any], run: Callable[..., Any]) -> click.Command:
    """Make a command that does `run`, with name and help of `function`: the first paragraph, whole, is what
    the list of commands shows."""
    text = inspect.getdoc(function) or ""
    short = " ".join(text.partition("\n\n")[0].split())
    return click.command(function.__name__.rstrip("_").replace("_", "-"), help=text, short_help=short)(run)


def result_command(
    *options: Option, csv: str, json: str = "", units: str = "mm and rad"
) -> Callable[[Callable[..., Result]], click.Command]:
    """Make a command of a function of a design's name, the design with its changes, and `options`.

    It gets a DESIGN, `--json` and `--csv`, whose help says what `json` holds, what a row of the `csv` is,
    and the `units`. Both at once are refused. The failure of a result is a line on standard error, except
    beside JSON, which has it, and exit status 1."""
    shared = (
        click.option("--json", "as_json", is_flag=True, help=f"Print JSON{json}, {units}."),
        click.option("--csv", "as_csv", is_flag=True, help=f"Print CSV, {csv}, {units}."),
        click.pass_context,
    )

    def command(compute: Callable[..., Result]) -> click.Command:
        """Make a command that prints what a function computes."""

        def run(context: click.Context, /, design: str, as_json: bool, as_csv: bool, **values: Any) -> None:
            """Read the design, compute, print."""
            if as_json and as_csv:
                raise click.UsageError("--json and --csv exclude each other: give one of them")
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its products are too small to be shared out
            changes = {name: values.pop(name) for name, *_ in OVERRIDES if name in values}
            changed = changed_design(load_design(design), changes)
            show(context, compute(click.format_filename(design), changed, **values), as_json, as_csv)

        own = block(click.argument("design", default=BUILTIN_DESIGN), *options, *shared)
        return named(compute, own(run))

    return command


def show(context: click.Context, result: Result, as_json: bool, as_csv: bool) -> None:
    """Print a result, and end with its exit status."""
    from ..report.result import csv_text, json_text

    if as_json:
        write_out(json_text(result.data()))
    else:
        write_out(csv_text(result.rows()) if as_csv else result.summary())
    if result.failure:
        if not as_json:
            click.echo(result.failure, err=True)
        context.exit(1)


@contextmanager
def refused_values() -> Iterator[None]:
    """Refuse what the calculation refuses of the values of options, in its words."""
    try:
        yield
    except ValueError as error:
        if type(error) is not ValueError:  # as LinAlgError is: no fault of the input
            raise
        raise Refusal([str(error)]) from None
