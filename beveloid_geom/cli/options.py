"""Shared parts of all commands: options, designs with changes, messages for bad input, output.

Commands import other packages inside their functions, so that `--help` is fast.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING, Any, TypeAlias

import click
from click.core import ParameterSource

from ..status import NotComputed
from ..support.process import NO_CONTACT, NOT_COMPUTED
from ..version import __version__

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from ..design.model import Design

BUILTIN_DESIGN = "ni-2017"
MEMBERS = ("pinion", "gear")
"""As `arrays.MEMBERS`, without the import of NumPy."""
Option: TypeAlias = Callable[[Callable[..., Any]], Callable[..., Any]]
"""Decorator that adds one or several options to a command."""


class Refusal(click.ClickException):
    """Bad input: one line for each different fault on standard error, exit status 2."""

    exit_code = 2

    def __init__(self, faults: Iterable[str]) -> None:
        """Store the lines of the message."""
        self.faults = tuple(dict.fromkeys(faults))
        super().__init__("\n".join(self.faults))

    def show(self, file: IO[Any] | None = None) -> None:
        """Write the lines."""
        for fault in self.faults:
            click.echo(f"Error: {fault}", file=file, err=True)


@contextmanager
def _usage_in_a_line() -> Iterator[None]:
    """Raise Refusal instead of Click's usage errors, which take up to ten lines."""
    try:
        yield
    except click.UsageError as error:
        if type(error).show is not click.UsageError.show:  # the help, without a command
            raise
        help_command = f" (see {error.ctx.command_path} --help)" if error.ctx else ""
        message = " ".join(error.format_message().split())
        for words, plain in (("float", "number"), ("integer", "whole number")):
            message = re.sub(f"is not a valid {words}( range)?", f"is not a {plain}", message)
        raise Refusal([message + help_command]) from None


class OneLineCommand(click.Command):
    """Command or group of commands whose usage errors are one line."""

    def make_context(self, *args: Any, **kwargs: Any) -> click.Context:
        """Parse the command line. Raises Refusal."""
        with _usage_in_a_line():
            return super().make_context(*args, **kwargs)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, or the named command of a group. Raises Refusal."""
        with _usage_in_a_line():
            try:
                return super().invoke(ctx)
            except ValueError as error:
                # Imported here, because NumPy is not needed for --help.
                from ..design.arguments import ModifiedFlanksError

                if isinstance(error, ModifiedFlanksError):
                    raise Refusal([str(error)]) from None
                raise


class NoResult(click.ClickException):
    """Missing result, such as no contact: one line on standard error."""

    exit_code = NO_CONTACT


class FailedCalculation(NoResult):
    """Result that is missing because its calculation failed."""

    exit_code = NOT_COMPUTED


def no_result(reason: str, what: str = "") -> NoResult:
    """Return the exception for the `reason` of a missing result: FailedCalculation if it is `NotComputed`.

    `what` names the missing result; it is printed before the reason."""
    kind = FailedCalculation if isinstance(reason, NotComputed) else NoResult
    return kind(f"{what}: {reason}" if what else reason)


def _require_number(value: Any, param: click.Parameter | None) -> None:
    """Raise Refusal for a value with a decimal comma or a unit."""
    from ..design.written_numbers import number_cure, refused

    metavar = str(getattr(param, "metavar", "") or "").lower()
    unit = metavar if metavar in ("mm", "deg") else ""
    if param is None or not isinstance(value, str):
        return
    cure = number_cure(value, unit)
    if param.multiple and param.nargs == 1 and "," in value:
        repeated = " ".join(f"{param.opts[0]} {part.strip()}" for part in value.split(","))
        cure = f"{cure}, or repeat the option, {repeated}" if cure else f"repeat the option, {repeated}"
    if cure:
        raise Refusal([f"{param.opts[0]} {refused('be a number', value, cure)}"])


class Number(click.types.FloatParamType):
    """Type of numbers. Text with a decimal comma or a unit is rejected; the message contains the number
    to give."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number. Raises Refusal or a usage error for other text."""
        _require_number(value, param)
        return super().convert(value, param, ctx)


class NumberRange(click.FloatRange):
    """Range that excludes NaN, which compares false with both ends."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number. Raises Refusal or a usage error for other text and for numbers outside the
        range."""
        _require_number(value, param)
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


ABOVE_ZERO = NumberRange(0.0, math.inf, min_open=True, max_open=True)


def block(*options: Option) -> Option:
    """Return one decorator for several options; the help shows them in this order."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(options):
            command = option(command)
        return command

    return add


def option_name(argument: str) -> str:
    """Return the name of the option for an argument."""
    return "--" + argument.replace("_", "-")


def given_options(arguments: Iterable[str]) -> list[str]:
    """Return the names of those options of the arguments that are on the command line."""
    source = click.get_current_context().get_parameter_source
    return [option_name(each) for each in arguments if source(each) is ParameterSource.COMMANDLINE]


def refuse_without(needed: str, arguments: Iterable[str]) -> None:
    """Raise Refusal for options on the command line that have no effect without the option `needed`."""
    if given := given_options(arguments):
        texts = (f"{name} has no effect without {needed}: add {needed}, or omit {name}" for name in given)
        raise Refusal(texts)


def option(
    name: str, kind: Any, default: Any, text: str, metavar: str | None = None, argument: str = ""
) -> Option:
    """Return an option that shows its default, if there is one. `argument` is the name of the argument if it
    differs."""
    names, shown = [name, argument or name.lstrip("-").replace("-", "_")], default not in (None, math.inf)
    numbers = {float: Number(), (float, float): (Number(), Number())}
    kind = numbers.get(kind, kind) if kind is float or isinstance(kind, tuple) else kind
    return click.option(*names, type=kind, default=default, show_default=shown, metavar=metavar, help=text)


def renamed(old: str, new: str) -> Option:
    """Return a hidden option with an old name. If it is used, an error message names the new option."""

    def refuse(_: click.Context, __: click.Parameter, value: str | None) -> None:
        """Raise Refusal if the old name is used."""
        if value is not None:
            raise Refusal([f"{old} has been renamed: use {new}"])

    place = "old_" + old.lstrip("-").replace("-", "_")
    return click.option(old, place, hidden=True, expose_value=False, is_eager=True, callback=refuse)


ERROR_OVERRIDES = (
    ("offset_error", "MM", "Error of the offset."),
    ("shaft_angle_error_deg", "DEG", "Error of the shaft angle, added to its magnitude."),
    ("pinion_axial_error", "MM", "Axial error of the pinion, positive towards +z."),
    ("gear_axial_error", "MM", "Axial error of the gear, positive towards +z."),
)
PARABOLAS = (
    ("parabola_pinion", "A", "Parabola coefficient of the pinion's tool, 1/mm; positive is concave."),
    ("parabola_gear", "A", "Parabola coefficient of the gear's tool, 1/mm; positive is concave."),
    ("parabola_right_pinion", "A", "Parabola coefficient of the pinion's right flanks only, 1/mm."),
    ("parabola_left_pinion", "A", "Parabola coefficient of the pinion's left flanks only, 1/mm."),
    ("parabola_right_gear", "A", "Parabola coefficient of the gear's right flanks only, 1/mm."),
    ("parabola_left_gear", "A", "Parabola coefficient of the gear's left flanks only, 1/mm."),
    (
        "parabola_apex_pinion",
        "MM",
        "Apex of the pinion's parabolas, from the reference line towards the tip.",
    ),
    ("parabola_apex_gear", "MM", "Apex of the gear's parabolas, from the reference line towards the tip."),
)
MODIFIED = tuple(
    (
        f"{member}_modification",
        "AMOUNTS",
        f"Modification of the {member}, in place of [{member}.modification]: amounts in um and lengths in mm,"
        ' such as "helix_crowning=10, tip_relief=15, tip_relief_length=2.5". "right.helix_crowning=10" is for'
        ' the right flanks only, "left." likewise; "none" removes the modification.',
    )
    for member in MEMBERS
)
OVERRIDES = ERROR_OVERRIDES + PARABOLAS + MODIFIED
"""Arguments of `design.file.override` with an option: name, metavar and help."""


def _modification(argument: str, metavar: str, text: str) -> Option:
    """Return the option for a modification, an argument of `design.file.override`."""
    name = option_name(argument)

    def read(value: str) -> dict[str, Any]:
        """Return the table of a design file for the amounts. Raises Refusal."""
        from ..design.amounts import read_amounts

        try:
            return read_amounts(value)
        except ValueError as error:
            raise Refusal([f"{name} {error}"]) from None

    return option(name, read, None, f"{text} Default: the value of the design.", metavar)


def _override(argument: str, metavar: str, text: str) -> Option:
    """Return the option for an argument of `design.file.override`."""
    return option(option_name(argument), float, None, f"{text} Default: the value of the design.", metavar)


tooth_options = block(
    *(_override(*each) for each in PARABOLAS),
    *(_modification(*each) for each in MODIFIED),
)
"""Options for the parabola coefficients, the position of their apex, and the modifications."""
override_options = block(
    *(_override(*each) for each in ERROR_OVERRIDES),
    tooth_options,
    renamed("--shaft-angle-error", "--shaft-angle-error-deg"),
)
"""Options for all values of a design that a command line may change."""


SIDES = click.Choice(["right", "left"])
flank_option = option("--flank", SIDES, "right", "Driving flanks.")


def points_option(default: int, along: str) -> Option:
    """Return the option `--points`: number of positions `along` a path or a cycle."""
    return option("--points", click.IntRange(2, 100_000), default, f"Positions {along}, both ends included.")


def bounds_options(text: str, default: tuple[float, float] | None = None) -> Option:
    """Return the options `--pinion-bounds` and `--gear-bounds`; {} in `text` is the member."""
    return block(
        *(
            option(f"--{member}-bounds", (float, float), default, text.format(member), "LOW HIGH")
            for member in MEMBERS
        )
    )


@contextmanager
def worker_processes(number: int, cure: str) -> Iterator[Executor]:
    """Start worker processes. If one is lost, raise Refusal with the `cure`."""
    from concurrent.futures.process import BrokenProcessPool

    from ..support.process import workers

    try:
        with workers(number) as pool:
            yield pool
    except BrokenProcessPool:
        raise Refusal([f"a process ended unexpectedly, perhaps for lack of memory: {cure}"]) from None


def progress_bar(total: int, unit: str) -> Any:
    """Return a progress bar on standard error, shown if this is a terminal."""
    from tqdm import tqdm

    return tqdm(total=total, desc=f"{unit}s", unit=unit, file=sys.stderr, disable=None)


def load_design(source: str) -> Design:
    """Return the design in a file, or a built-in design by its name. Raises Refusal."""
    from ..design.field_limits import DesignError
    from ..workshop.design_file import read_design

    try:
        return read_design(source)
    except DesignError as error:
        name = click.format_filename(error.source) or "''"
        raise Refusal(f"{name}: {fault}" for fault in error.faults) from None


def changed_design(design: Design, changes: Mapping[str, Any]) -> Design:
    """Return the design with the values of options, by the names of OVERRIDES. Raises Refusal with the names
    of the options."""
    from ..design.file import DesignError, override

    # Errors at the mesh are equivalent to four errors about the common perpendicular. An option would replace
    # one of the four and keep the other three.
    if design.errors_at == "mesh" and any(vars(design.errors).values()):
        for name, *_ in ERROR_OVERRIDES:
            if changes.get(name) is not None:
                where = "is about the common perpendicular, but the errors of the design are at the mesh"
                raise Refusal([f"{option_name(name)} {where}: change [errors] in the design file"])
    try:
        return override(design, **changes)
    except DesignError as error:
        raise Refusal(
            f"{option_name(fault.key)} {fault.text}" if fault.key in changes else str(fault)
            for fault in error.parts
        ) from None


def note_equal_teeth(design: Design) -> None:
    """Write a line on standard error for each flank whose single teeth differ, for a command that computes
    equal teeth."""
    from ..arrays import FLANK_SIGN

    for flank in FLANK_SIGN:
        for name, member in zip(MEMBERS, design.members, strict=True):
            keys = []
            if member.pitch_deviations(flank) is not None:
                keys.append("no pitch_deviations_um")
            if tables := member.tooth_deviations(flank):
                keys.append(f"the mean of {len(tables)} measured teeth")
            if keys:
                words = f"[{name}.modification] {flank} flanks are computed with {' and '.join(keys)}"
                click.echo(
                    f"Note: {words}; operation and render-report compute the transmission error of all teeth",
                    err=True,
                )


def write_out(text: str) -> None:
    """Write to standard output; `process` handles failures."""
    click.echo(text, nl=False)


def version_option(name: str) -> Option:
    """Return the option `--version` of a command."""
    return click.version_option(__version__, prog_name=name)
