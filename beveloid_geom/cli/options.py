"""What the commands share: reading designs, refusing bad input, writing to standard output.

A command imports the rest of the package inside its function: `--help` must not wait for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import IO, TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ..design.model import Design

BUILTIN_DESIGN = "ni-2017"
Command = Callable[..., Any]

OVERRIDES = (
    ("offset_error", "MM", "Error of the offset."),
    ("shaft_angle_error_deg", "DEG", "Error of the shaft angle, added to its magnitude."),
    ("pinion_axial_error", "MM", "Axial error of the pinion, positive towards its heel."),
    ("gear_axial_error", "MM", "Axial error of the gear, positive towards its heel."),
    ("parabola_pinion", "A", "Parabola coefficient of the pinion's tool, 1/mm; positive is concave."),
    ("parabola_gear", "A", "Parabola coefficient of the gear's tool, 1/mm; positive is concave."),
)
"""Arguments of `design.file.override` that have an option, its metavar and help."""


class Refusal(click.ClickException):
    """Bad input: one line for every fault on standard error, exit status 2."""

    exit_code = 2

    def __init__(self, faults: Iterable[str]) -> None:
        """Take the lines to be shown."""
        self.faults = tuple(faults)
        super().__init__("\n".join(self.faults))

    def show(self, file: IO[Any] | None = None) -> None:
        """Write the lines."""
        for fault in self.faults:
            click.echo(f"Error: {fault}", file=file, err=True)


def option_name(argument: str) -> str:
    """The option for an argument of `design.file.override`; its unit stands in the metavar."""
    return "--" + argument.removesuffix("_deg").replace("_", "-")


ERROR_SIZES = (
    ("--offset", "MM", 1000.0, "offset"),
    ("--shaft-angle-deg", "DEG", 5.0, "shaft angle"),
    ("--pinion-axial", "MM", 1000.0, "pinion's axial position"),
    ("--gear-axial", "MM", 1000.0, "gear's axial position"),
)
"""Options, units, greatest values and names of the assembly errors."""


def require_sizes(what: str, sizes: Iterable[float]) -> None:
    """Raises Refusal if all sizes are 0; `what` they are, such as tolerances."""
    if not any(sizes):
        *most, last = (name for name, *_ in ERROR_SIZES)
        raise Refusal([f"no {what}: give {', '.join(most)} or {last}"])


class NumberRange(click.FloatRange):
    """A range that NaN is not in: it compares false with both ends."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number; fails if it is none or outside."""
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


def override_options(command: Command) -> Command:
    """One option for each value of a design that a command line may change."""
    return _options(command, OVERRIDES)


def parabola_options(command: Command) -> Command:
    """Those of the override options that change the members."""
    return _options(command, OVERRIDES[-2:])


def error_sizes(words: str) -> Callable[[Command], Command]:
    """An option for the size of each of the four assembly errors; `words` are what it is."""

    def add(command: Command) -> Command:
        for name, metavar, most, what in reversed(ERROR_SIZES):
            kind = NumberRange(0.0, most)
            text = f"{words} of the {what}, to either side."
            command = click.option(
                name, type=kind, default=0.0, show_default=True, metavar=metavar, help=text
            )(command)
        return command

    return add


def _options(command: Command, overrides: Sequence[tuple[str, str, str]]) -> Command:
    for argument, metavar, text in reversed(overrides):
        text = f"{text} Default: that of the design."
        command = click.option(option_name(argument), argument, type=float, metavar=metavar, help=text)(
            command
        )
    return command


def flank_option(command: Command) -> Command:
    """Option `--flank`."""
    choice = click.Choice(["right", "left"])
    return click.option("--flank", type=choice, default="right", show_default=True)(command)


def format_options(command: Command) -> Command:
    """Options `--json` and `--csv`; `require_one_format` goes with them."""
    rows = "Print CSV, one position a row, mm and rad."
    command = click.option("--csv", "as_csv", is_flag=True, help=rows)(command)
    return click.option("--json", "as_json", is_flag=True, help="Print JSON, mm and rad.")(command)


def require_one_format(as_json: bool, as_csv: bool) -> None:
    """Raises UsageError for both formats at once."""
    if as_json and as_csv:
        raise click.UsageError("--json and --csv exclude each other: give one of them")


def load_design(source: str) -> Design:
    """The design in the file `source`, or the built-in one by its name. Raises Refusal."""
    from ..design.file import DesignError, read_design

    try:
        return read_design(source)
    except DesignError as error:
        name = click.format_filename(error.source)
        raise Refusal(f"{name}: {fault}" for fault in error.faults) from None


def changed_design(design: Design, changes: dict[str, float | None]) -> Design:
    """The design with the values of options, by the names of OVERRIDES. Raises Refusal, which
    speaks of the options."""
    from ..design.file import DesignError, override

    try:
        return override(design, **changes)
    except DesignError as error:
        words = [fault.partition(" ") for fault in error.faults]
        raise Refusal(
            f"{option_name(first) if first in changes else first} {rest}" for first, _, rest in words
        ) from None


def end_if_jammed(context: click.Context, design: Design, quiet: bool) -> None:
    """End with exit status 1 where the pair cannot be put together, with a line on standard error unless
    `quiet`."""
    from ..report.backlash import backlash_report

    jam = backlash_report(design).jam
    if jam:
        if not quiet:
            click.echo(f"Jammed: {jam}", err=True)
        context.exit(1)


def write_out(text: str) -> None:
    """Write to standard output; what happens where that fails is said in `process`."""
    click.echo(text, nl=False)


def version_option(name: str) -> Callable[[Command], Command]:
    """Option `--version` of the command called `name`."""
    return click.version_option(package_name="beveloid-geom", prog_name=name)
