"""What the commands share: options, designs with changes, refusals, writing to standard output.

A command imports the rest of the package inside its function: `--help` must not wait for it.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import IO, TYPE_CHECKING, Any, TypeAlias

import click

if TYPE_CHECKING:
    from ..design.model import Design, Errors, MeshErrors

BUILTIN_DESIGN = "ni-2017"
Option: TypeAlias = Callable[[Callable[..., Any]], Callable[..., Any]]
"""A decorator that gives a command an option, or several."""


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


class NumberRange(click.FloatRange):
    """A range that NaN is not in: it compares false with both ends."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the number; fails if it is none or outside."""
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


def block(*options: Option) -> Option:
    """Make one decorator of several, in the order in which help shows them."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(options):
            command = option(command)
        return command

    return add


def option_name(argument: str) -> str:
    """Give the option of an argument."""
    return "--" + argument.replace("_", "-")


def option(
    name: str, kind: Any, default: Any, text: str, metavar: str | None = None, argument: str = ""
) -> Option:
    """Make an option that shows its default, if it has one, for an `argument` if that has another name."""
    names, shown = [name, argument or name.lstrip("-").replace("-", "_")], default not in (None, math.inf)
    return click.option(*names, type=kind, default=default, show_default=shown, metavar=metavar, help=text)


def renamed(old: str, new: str) -> Option:
    """Refuse an option that has another name by now, with a line that says so."""

    def refuse(_: click.Context, __: click.Parameter, value: str | None) -> None:
        if value is not None:
            raise Refusal([f"{old} has a new name: write {new}"])

    place = "old_" + old.lstrip("-").replace("-", "_")
    return click.option(old, place, hidden=True, expose_value=False, is_eager=True, callback=refuse)


OVERRIDES = (
    ("offset_error", "MM", "Error of the offset."),
    ("shaft_angle_error_deg", "DEG", "Error of the shaft angle, added to its magnitude."),
    ("pinion_axial_error", "MM", "Axial error of the pinion, positive towards its heel."),
    ("gear_axial_error", "MM", "Axial error of the gear, positive towards its heel."),
    ("parabola_pinion", "A", "Parabola coefficient of the pinion's tool, 1/mm; positive is concave."),
    ("parabola_gear", "A", "Parabola coefficient of the gear's tool, 1/mm; positive is concave."),
)
"""Arguments of `design.file.override` that have an option, its metavar and help."""


def _override(argument: str, metavar: str, text: str) -> Option:
    return option(option_name(argument), float, None, f"{text} Default: that of the design.", metavar)


parabola_options = block(*(_override(*each) for each in OVERRIDES[-2:]))
"""Those of the override options that change the members."""
override_options = block(
    *(_override(*each) for each in OVERRIDES[:-2]),
    parabola_options,
    renamed("--shaft-angle-error", "--shaft-angle-error-deg"),
)
"""One option for each value of a design that a command line may change."""

TOLERANCES = (
    ("offset", "--offset-tolerance", "MM", 1000.0, "offset", "--offset"),
    ("shaft_angle_deg", "--shaft-angle-tolerance-deg", "DEG", 5.0, "shaft angle", "--shaft-angle-deg"),
    ("pinion_axial", "--pinion-axial-tolerance", "MM", 1000.0, "pinion's axial position", "--pinion-axial"),
    ("gear_axial", "--gear-axial-tolerance", "MM", 1000.0, "gear's axial position", "--gear-axial"),
    ("centre_distance", "--centre-distance-tolerance", "MM", 1000.0, "centre distance at the mesh", ""),
    ("in_plane_deg", "--in-plane-tolerance-deg", "DEG", 5.0, "shaft angle about the mesh point", ""),
    ("out_of_plane_deg", "--out-of-plane-tolerance-deg", "DEG", 5.0, "tilt out of the axes' plane there", ""),
)
"""Argument, option, unit, greatest value and name of the sizes of assembly errors, and the option's old
name, if it had another."""


def _tolerance(argument: str, name: str, metavar: str, most: float, what: str, _: str) -> Option:
    text = f"Tolerance of the {what}, to either side."
    return option(name, NumberRange(0.0, most), 0.0, text, metavar, argument=argument)


tolerance_options = block(
    *(_tolerance(*each) for each in TOLERANCES),
    *(renamed(old, option) for _, option, *_, old in TOLERANCES if old),
)
"""An option for the size of each assembly error, to either side."""


def errors_option(name: str, default: str | None, text: str) -> Option:
    """Make an option of two different assembly errors, as in offset,shaft-angle: by their names, with or
    without -error, or by the letters of the trade."""

    def read(value: str) -> tuple[str, str]:
        """Give their names as `Errors` has them. Raises Refusal."""
        from ..pair.errors import ALL_NAMES, place_of
        from ..report.words import TRADE

        letters = {letter.lower(): error for error, letter in TRADE.items()}
        words = [word.strip().lower().replace("-", "_").removesuffix("_error") for word in value.split(",")]
        found = [letters.get(word, word) for word in words]
        if len(found) != 2 or len(set(found)) != 2 or not set(found) <= set(ALL_NAMES):
            known = ", ".join(
                error.replace("_", "-") + (f" ({TRADE[error]})" if error in TRADE else "")
                for error in ALL_NAMES
            )
            raise Refusal([f"{name} must be two different ones of {known}, a comma between, got {value!r}"])
        try:
            place_of(found)
        except ValueError as error:
            raise Refusal([f"{name}: {error}"]) from None
        return found[0], found[1]

    return option(name, read, default, text, "ERROR,ERROR")


def sizes_of(values: Mapping[str, float], needed: str = "") -> dict[str, float]:
    """Give the tolerances that are not 0, by the names of their errors, in mm and rad. Raises Refusal if all
    are 0 where they are `needed`, such as 'tolerances', and for those of errors of two places."""
    from ..pair.errors import NAMES, place_of

    if needed and not any(values.values()):
        *most, last = (option for _, option, *_ in TOLERANCES)
        raise Refusal([f"no {needed}: give {', '.join(most)} or {last}"])
    options = {
        argument.removesuffix("_deg"): option for argument, option, *_ in TOLERANCES if values[argument]
    }
    try:
        place_of(tuple(options))
    except ValueError:
        first, second = (
            next(option for name, option in options.items() if name not in NAMES[place])
            for place in ("mesh", "perpendicular")
        )
        cure = "leave one of them out"
        raise Refusal([f"{first} is about the common perpendicular, {second} at the mesh: {cure}"]) from None
    return {
        argument.removesuffix("_deg"): math.radians(value) if argument.endswith("_deg") else value
        for argument, value in values.items()
        if value
    }


def errors_of(sizes: Mapping[str, float]) -> Errors | MeshErrors:
    """Give errors as large as sizes by their names, mm or rad, of the place where those are measured."""
    from ..pair.errors import KINDS, place_of

    return KINDS[place_of(tuple(sizes))](**sizes)


SIDES = click.Choice(["right", "left"])
flank_option = option("--flank", SIDES, "right", "Which flanks carry.")


def points_option(default: int, along: str) -> Option:
    """Give option `--points`, how many positions `along` something."""
    return option("--points", click.IntRange(2, 100_000), default, f"Positions {along}, both ends included.")


def bounds_options(text: str, default: tuple[float, float] | None = None) -> Option:
    """Give options `--pinion-bounds` and `--gear-bounds`, two numbers each; in `text` {} is the member."""
    return block(
        *(
            option(f"--{member}-bounds", (float, float), default, text.format(member), "LOW HIGH")
            for member in ("pinion", "gear")
        )
    )


def progress_bar(total: int, unit: str) -> Any:
    """Make a bar on standard error, if that is a terminal."""
    from tqdm import tqdm

    return tqdm(total=total, desc=f"{unit}s", unit=unit, file=sys.stderr, disable=None)


def load_design(source: str) -> Design:
    """Read the design in the file `source`, or a built-in one by its name. Raises Refusal."""
    from ..design.field_limits import DesignError
    from ..pair.mesh_errors import read_design

    try:
        return read_design(source)
    except DesignError as error:
        name = click.format_filename(error.source)
        raise Refusal(f"{name}: {fault}" for fault in error.faults) from None


def changed_design(design: Design, changes: Mapping[str, float | None]) -> Design:
    """Give the design with the values of options, by the names of OVERRIDES. Raises Refusal, which
    speaks of the options."""
    from ..design.file import DesignError, override

    # With one of four replaced by their equals about the perpendicular the other three would stay.
    if design.errors_at == "mesh" and any(vars(design.errors).values()):
        for name, *_ in OVERRIDES[:-2]:
            if changes.get(name) is not None:
                where = "is about the common perpendicular, the errors of the design are at the mesh"
                raise Refusal([f"{option_name(name)} {where}: change [errors] of its file"])
    try:
        return override(design, **changes)
    except DesignError as error:
        raise Refusal(
            f"{option_name(fault.key)} {fault.text}" if fault.key in changes else str(fault)
            for fault in error.parts
        ) from None


def write_out(text: str) -> None:
    """Write to standard output; what happens where that fails is said in `process`."""
    click.echo(text, nl=False)


def version_option(name: str) -> Option:
    """Give option `--version` of the command called `name`."""
    return click.version_option(package_name="beveloid-geom", prog_name=name)
