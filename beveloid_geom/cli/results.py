"""Shared parts of the commands that print a result.

A new command is one module in a package of `commands`, with a function of the name of the design, the design
and the options:

    @results.result_command(flank_option, override_options, csv="one position per row")
    def mine(name: str, design: results.Design, flank: str) -> results.Result:
        '''One sentence for the list of commands.'''
        from ....report.mine import my_report

        return my_report(name, design, flank)
"""

from __future__ import annotations

import errno
import inspect
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..support.argument import ArgumentError
from .options import (
    BUILTIN_DESIGN,
    OVERRIDES,
    Option,
    Refusal,
    block,
    changed_design,
    load_design,
    note_equal_teeth,
    option_name,
    refuse_without,
    write_out,
)

if TYPE_CHECKING:  # annotations of commands are not evaluated
    from ..design.model import Design as Design
    from ..report.result import Result as Result


def named(function: Callable[..., Any], run: Callable[..., Any]) -> click.Command:
    """Return a command that calls `run`, with the name and the help of `function`.

    The list of commands shows the complete first paragraph of the help."""
    text = inspect.getdoc(function) or ""
    short = " ".join(text.partition("\n\n")[0].split())
    name = function.__name__.removesuffix("_command").rstrip("_").replace("_", "-")
    return click.command(name, help=text, short_help=short)(run)


def result_command(
    *options: Option, csv: str, json: str = "", units: str = "mm and rad", each_tooth: bool = False
) -> Callable[[Callable[..., Result]], click.Command]:
    """Return a decorator that makes a command from a function of the name of a design, the design and
    options.

    The command has a DESIGN, `--json` and `--csv`, which exclude each other. A failure sets the exit status
    and is one line on standard error, except with JSON, which contains the reason.

    Parameters
    ----------
    *options : Option
        Options of the command; those of OVERRIDES change the design.
    csv, json, units : str
        Contents of a row of CSV, contents of JSON, and units, for the help.
    each_tooth : bool
        Whether the command uses the deviations of single teeth. Other commands say that they do not.
    """
    shared = (
        click.option("--json", "as_json", is_flag=True, help=f"Print JSON{json}, {units}."),
        click.option("--csv", "as_csv", is_flag=True, help=f"Print CSV, {csv}, {units}."),
        click.pass_context,
    )

    def command(compute: Callable[..., Result]) -> click.Command:
        """Return a command that prints the result of a function."""

        def run(context: click.Context, /, design: str, as_json: bool, as_csv: bool, **values: Any) -> None:
            """Read the design, compute and print the result."""
            if as_json and as_csv:
                raise click.UsageError("--json and --csv exclude each other: give one of them")
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads do not pay for small products
            changes = {name: values.pop(name) for name, *_ in OVERRIDES if name in values}
            changed = changed_design(load_design(design), changes)
            if not each_tooth:
                note_equal_teeth(changed)
            show(context, compute(click.format_filename(design), changed, **values), as_json, as_csv)

        decorate = block(click.argument("design", default=BUILTIN_DESIGN), *options, *shared)
        return named(compute, decorate(run))

    return command


def show(context: click.Context, result: Result, as_json: bool, as_csv: bool) -> None:
    """Print a result and exit with its status."""
    from ..report.result import csv_text, json_text

    if as_json:
        write_out(json_text(result.data()))
    else:
        write_out(csv_text(result.rows()) if as_csv else result.summary())
    if result.failure:
        if not as_json:
            click.echo(result.failure.text, err=True)
        context.exit(result.failure.status)


@contextmanager
def refused_values(options: Mapping[str, str] | None = None) -> Iterator[None]:
    """Convert a ValueError of the calculation to a Refusal with the same message.

    An ArgumentError is converted to a message with the option of the argument: that in `options`, or the
    option with the name of the argument."""
    try:
        yield
    except ArgumentError as error:
        name = (options or {}).get(error.argument) or option_name(error.argument)
        raise Refusal([f"{name} {error.text}"]) from None
    except ValueError as error:
        if type(error) is not ValueError:  # subclasses such as LinAlgError are not faults of the input
            raise
        raise Refusal([str(error)]) from None


out_options = block(
    click.option(
        "--out", type=click.Path(path_type=Path), metavar="FILE", help="Write the result as a design file."
    ),
    click.option("--overwrite", is_flag=True, help="Replace the file --out if it exists."),
)
"""Options of a design file that a command writes."""


def check_out(out: Path | None, overwrite: bool) -> None:
    """Raise Refusal for a folder that does not exist, and for a file that exists without `overwrite`."""
    if out is None:
        refuse_without("--out", ("overwrite",))
        return
    _check_file_name(out)
    if not out.parent.is_dir():
        raise _cannot_write(out, os.strerror(errno.ENOENT))
    if out.exists() and not overwrite:
        name = click.format_filename(out)
        raise Refusal([f"{name} exists already: add --overwrite, or choose another --out"])


def check_measured(design: Design, members: Iterable[str], flank: str, out: Path | None) -> None:
    """Raise Refusal if a design with measured flanks would be written with changed amounts of modification.

    A design file compares the measured points with its flanks, including their amounts: on reading, the
    deviations would undo the change."""
    for name in members if out is not None else ():
        modification = getattr(design, name).modification(flank)
        if modification is not None and modification.deviations is not None:
            text = "has measured deviations, which would undo the change when the file is read"
            raise Refusal([f"--out: [{name}.modification] {text}: omit --out, or remove the deviations"])


def write_design(text: str, out: Path) -> None:
    """Write the text of a design file. Raises Refusal if the file cannot be written."""
    from ..support.atomic_file import atomic_file

    try:
        with atomic_file(out) as temporary:
            temporary.write_text(text, encoding="utf-8")
    except OSError as error:
        raise _cannot_write(out, error.strerror or error) from None


def unfinished_file(out: Path) -> AbstractContextManager[Path]:
    """Return `atomic_file` of a path. Raises Refusal for a folder, and for a file in a missing folder."""
    from ..support.atomic_file import atomic_file

    _check_file_name(out)
    require_folder(out)
    return atomic_file(out)


def require_folder(out: Path) -> None:
    """Raise Refusal for a file in a missing folder."""
    if not out.parent.is_dir():
        folder = click.format_filename(out.parent)
        raise Refusal([f"--out: the folder {folder} does not exist: create it first"])


def _check_file_name(out: Path) -> None:
    """Raise Refusal for a folder, and for `-`, the usual name of standard output."""
    if out.is_dir() or str(out) == "-":
        kind = "standard output, which is for the result" if str(out) == "-" else "a folder"
        raise Refusal([f"--out: {click.format_filename(out)} is {kind}: give the name of a file"])


def _cannot_write(out: Path, reason: object) -> Refusal:
    return Refusal([f"cannot write {click.format_filename(out)} ({reason}): choose another --out"])
