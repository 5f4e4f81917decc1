"""Options for the sizes of assembly errors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from .options import NumberRange, Option, Refusal, block, option, renamed

if TYPE_CHECKING:
    from ..design.model import Design, Errors, MeshErrors

TOLERANCES = (
    ("offset", "--offset-tolerance", "MM", 1000.0, "offset", "--offset"),
    ("shaft_angle_deg", "--shaft-angle-tolerance-deg", "DEG", 5.0, "shaft angle", "--shaft-angle-deg"),
    ("pinion_axial", "--pinion-axial-tolerance", "MM", 1000.0, "pinion's axial position", "--pinion-axial"),
    ("gear_axial", "--gear-axial-tolerance", "MM", 1000.0, "gear's axial position", "--gear-axial"),
    ("centre_distance", "--centre-distance-tolerance", "MM", 1000.0, "centre distance at the mesh", ""),
    ("in_plane_deg", "--in-plane-tolerance-deg", "DEG", 5.0, "shaft angle about the pitch point", ""),
    (
        "out_of_plane_deg",
        "--out-of-plane-tolerance-deg",
        "DEG",
        5.0,
        "tilt out of the plane of the axes at the mesh",
        "",
    ),
)
"""Sizes of assembly errors: argument, option, unit, largest value, name of the quantity, and old name of the
option, if any."""


def _tolerance(argument: str, name: str, metavar: str, most: float, quantity: str, _: str) -> Option:
    """Return the option for the size of an assembly error."""
    text = f"Tolerance of the {quantity}, in both directions."
    return option(name, NumberRange(0.0, most), None, text, metavar, argument=argument)


tolerance_options = block(
    *(_tolerance(*each) for each in TOLERANCES),
    *(renamed(old, option) for _, option, *_, old in TOLERANCES if old),
)
"""Options for the sizes of all assembly errors; None if they are not on the command line."""


def tolerance_names(prefix: str) -> dict[str, str]:
    """Return the options of the tolerances by the argument of an ArgumentError, `prefix` and the error."""
    return {f"{prefix} {argument.removesuffix('_deg')}": option for argument, option, *_ in TOLERANCES}


def given_tolerances(values: Mapping[str, float | None]) -> dict[str, str]:
    """Return the options of the tolerances that are not None by the name of their error."""
    given = (row for row in TOLERANCES if values[row[0]] is not None)
    return {argument.removesuffix("_deg"): option for argument, option, *_ in given}


def errors_option(name: str, default: str | None, text: str) -> Option:
    """Return an option for two different assembly errors, such as offset,shaft-angle.

    The errors are given by name, with or without -error, or by their usual letters.

    Parameters
    ----------
    name : str
        Name of the option.
    default : str or None
        Default as on a command line.
    text : str
        Help.

    Returns
    -------
    Option
    """

    def read(value: str) -> tuple[str, str]:
        """Return the names of the errors as in `Errors`. Raises Refusal."""
        from ..pair.misalignment import ALL_NAMES, place_of
        from ..report.text import SYMBOLS

        letters = {letter.lower(): error for error, letter in SYMBOLS.items()}
        words = [word.strip().lower().replace("-", "_").removesuffix("_error") for word in value.split(",")]
        names = [letters.get(word, word) for word in words]
        if len(names) != 2 or len(set(names)) != 2 or not set(names) <= set(ALL_NAMES):
            known = ", ".join(
                error.replace("_", "-") + (f" ({SYMBOLS[error]})" if error in SYMBOLS else "")
                for error in ALL_NAMES
            )
            text = f"{name} must be two different errors, separated by a comma, got {value!r}"
            raise Refusal([f"{text}: choose from {known}"])
        try:
            place_of(names)
        except ValueError as error:
            raise Refusal([f"{name}: {error}"]) from None
        return names[0], names[1]

    return option(name, read, default, text, "ERROR,ERROR")


def sizes_of(values: Mapping[str, float | None], usual_of: Design | None = None) -> dict[str, float]:
    """Return the tolerances that are not 0 by name of their errors, in mm and rad.

    If no tolerance is given (all are None) and a design `usual_of` is given, the usual tolerances of its
    errors are returned. Raises Refusal if all given tolerances are 0, or if errors about the common
    perpendicular are mixed with errors at the mesh."""
    from ..pair.misalignment import NAMES, place_of

    given = given_tolerances(values)
    if given and not any(values.values()):
        words = f"at least one tolerance must be above 0, got 0 for {', '.join(given.values())}"
        raise Refusal([f"{words}: omit all of them for the usual tolerances"])
    if usual_of is not None and not given:
        from ..analysis.tolerance import USUAL_AT

        usual = USUAL_AT[usual_of.errors_at]
        return dict(zip(usual.names, usual.values().tolist(), strict=True))
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
        cure = "omit one of them"
        text = f"{first} is about the common perpendicular, but {second} is at the mesh"
        raise Refusal([f"{text}: {cure}"]) from None
    return {
        argument.removesuffix("_deg"): math.radians(value) if argument.endswith("_deg") else value
        for argument, value in values.items()
        if value
    }


def errors_of(sizes: Mapping[str, float]) -> Errors | MeshErrors:
    """Return errors of the given sizes, mm or rad, about the common perpendicular or at the mesh."""
    from ..pair.misalignment import ERROR_CLASSES, place_of

    return ERROR_CLASSES[place_of(tuple(sizes))](**sizes)
