"""Design files: TOML in mm and degrees, converted to the inputs of `model`.

The numbers of each table become keyword arguments of `from_degrees`. They are checked once, against the
limits of `field_limits`; combinations of keys are checked by `limits`. All faults are reported together, one
line each with key, limit, value and likely cure. Undercut, pointed teeth and backlash are not faults of a
file.
"""

from __future__ import annotations

import difflib
import math
import os
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, fields, replace
from importlib import resources
from typing import Any, TypeAlias

from ..support.text_file import TextFileError, read_text
from .field_limits import (
    LIMITS,
    DesignError as DesignError,
    Fault,
    Limit,
    in_radians,
    number_cure,
    number_fault,
    refused,
    shown_value,
)
from .limits import (
    LEAST_TIP_HEIGHT,
    given_at_mesh_faults,
    member_faults,
    mesh_error_faults,
    mesh_faults,
    offset_error_faults,
    outside,
    parallel_faults,
    radian_faults,
    tip_radius_at_mid_face,
)
from .model import (
    BY_FLANK,
    MODIFICATIONS,
    Design,
    Errors,
    ErrorsAt,
    Member,
    MeshErrors,
    Pair,
    Tool,
    from_degrees,
)
from .modification import Modification, limits_of, missing_amounts, missing_lengths

BUILTIN = "ni-2017"
BUILTINS = {
    BUILTIN: "crossed pair of Table 1 of Ni et al. 2017: m 6, 29/45 teeth, offset 229 mm, 15 deg",
    "awd-transfer": "transfer pair for all-wheel drive: m 3, 37/37 teeth, intersecting axes, 4 deg",
    "marine-gearbox": "reduction of a marine gearbox: m 6, 24/61 teeth, intersecting axes, 7 deg",
    "anti-backlash": "backlash set by an axial shift: m 1.5, 24/72 straight teeth on cones, parallel axes",
}
"""Built-in designs by name, with a description."""
_NAMES = ", ".join(BUILTINS)
MAX_FILE_BYTES = 1_000_000
"""Largest size of a design file; the built-in ones have about 2,000 bytes."""
FromMesh: TypeAlias = Callable[[Design, MeshErrors], Errors]
"""`pair.misalignment_at_mesh.from_mesh`, which needs the pitch point of the design."""


def _limits_of(*inputs: type) -> dict[str, Limit]:
    """Return the limits of classes of `design.model` by key of a file; keys of angles end in `_deg`."""
    return {
        name + ("_deg" if limit.unit == "deg" else ""): limit
        for kind in inputs
        for name, limit in LIMITS[kind.__name__].items()
    }


def _required(*inputs: type) -> set[str]:
    """Return the keys of classes of `design.model` that have no default."""
    names = {field.name for kind in inputs for field in fields(kind) if field.default is MISSING}
    return {key for key in _limits_of(*inputs) if key.removesuffix("_deg") in names}


_DIAMETER = Limit(0.001, 1e6, "mm", ((math.inf, "give the tip diameter at mid-face in mm"),))
_TOOL = {key: limit for key, limit in _limits_of(Tool).items() if not key.startswith("parabola")}
_MEMBER = {**_limits_of(Tool, Member), "tip_diameter": _DIAMETER}
_TABLES = {
    "tool": _TOOL,
    "pinion": _MEMBER,
    "gear": _MEMBER,
    "pair": _limits_of(Pair),
    "errors": _limits_of(Errors),
}
"""Limits of the keys by table."""
_MODIFICATION = limits_of(Modification)
"""Limits of the keys of [pinion.modification] and [gear.modification]."""
_ERRORS_AT = {"perpendicular": _TABLES["errors"], "mesh": _limits_of(MeshErrors)}
"""Keys of [errors] for each value of `at`."""
_MISSING = "is missing: the built-in design shows all tables and keys"


def _guess(word: str, known: Iterable[str]) -> str | None:
    """Return the known name that is most similar to a misspelt one."""
    return next(iter(difflib.get_close_matches(word.lower(), list(known), n=1)), None)


def _unknown(table: str, key: str, value: object, keys: Iterable[str] = ()) -> Fault:
    """Return the fault of an unknown key of a table; the table is '' for keys above the first table."""
    known = list(keys) if table else [f"[{name}]" for name in _TABLES]
    shown = key if re.fullmatch(r"[\w-]{1,40}", key) else shown_value(key)
    if isinstance(value, dict) and not table:
        shown = f"[{shown}]"
    elif table == "errors" and (places := [at for at, keys_at in _ERRORS_AT.items() if key in keys_at]):
        return Fault(table, shown, f'needs at = "{places[0]}": the keys here are {", ".join(known)}')
    elif tables := [f"[{name}]" for name, keys in _TABLES.items() if key in keys]:
        return Fault(table, shown, f"does not belong here: move it to {' or '.join(tables)}")
    guess = _guess(shown, known)
    hint = f"did you mean {guess}?" if guess else f"known are {', '.join(known)}"
    return Fault(table, shown, f"is unknown: {hint}")


def _checked(
    known: Mapping[str, Limit],
    table: str,
    given: Mapping[str, Any],
    faults: list[Fault],
    required: Iterable[str] = (),
) -> dict[str, Any] | None:
    """Return the numbers of a table, or None after adding its faults to `faults`."""
    unknown = [key for key in given if key not in known]
    # A misspelt key is one mistake, not an unknown key and a missing one.
    meant = {_guess(key, known) for key in unknown}
    new: list[Fault] = []
    for key, limit in known.items():
        if key in given and (text := number_fault(given[key], limit)):
            new.append(Fault(table, key, text))
        elif key not in given and key in required and key not in meant:
            new.append(Fault(table, key, _MISSING))
    new += [_unknown(table, key, given[key], known) for key in unknown]
    faults += new
    return None if new else {key: given[key] for key in known if key in given}


def _read_member(name: str, tables: dict[str, dict[str, Any]], faults: list[Fault]) -> Member | None:
    """Read a member with the keys that it inherits from [tool].

    Faults of inherited keys are reported for [tool] only."""
    given, shared = dict(tables[name]), tables.get("tool", {})
    modifications = _read_modifications(f"{name}.modification", given.pop("modification", {}), faults)
    inherited = {key: shared[key] for key in _TOOL if key in shared and key not in given}
    new: list[Fault] = []
    values = _checked(_MEMBER, name, inherited | given, new, _required(Tool, Member))
    if values is None:
        faults += [fault for fault in new if fault.key in given or fault.key not in _TOOL]
        return None
    tool = {key: values.pop(key) for key in _limits_of(Tool) if key in values}
    diameter = values.pop("tip_diameter", None)
    member = from_degrees(Member, tool=from_degrees(Tool, **tool), **values, **modifications)
    if diameter is not None and "tip_alteration" in given:
        faults.append(Fault(name, "tip_diameter", "is given together with tip_alteration: leave one out"))
        return None
    if diameter is not None:
        least, most = (
            float(f"{2.0 * float(tip_radius_at_mid_face(replace(member, tip_alteration=k))):.6g}")
            for k in (LEAST_TIP_HEIGHT - member.tool.addendum, LIMITS["Member"]["tip_alteration"].high)
        )
        if not least <= diameter <= most:
            cure = "it is twice the tip radius at mid-face and includes the profile shift"
            faults.append(outside(name, "tip_diameter", f"be between {least} and {most} mm", diameter, cure))
            return None
        member = member.with_tip_diameter(diameter)
    for fault in member_faults(name, member):
        faults.append(fault._replace(table="tool") if fault.key in inherited else fault)
    return member


def _read_modifications(table: str, given: object, faults: list[Fault]) -> dict[str, Modification | None]:
    """Read the table of the modification of a member, with tables for one flank, by field of `Member`."""
    both, flanks = given, {}
    if isinstance(given, dict):
        flanks = {name: value for name, value in given.items() if name in MODIFICATIONS}
        unknown = [name for name, value in given.items() if isinstance(value, dict) and name not in flanks]
        known = " and ".join(MODIFICATIONS)
        faults += (Fault(table, name, f"is unknown: tables for one flank are {known}") for name in unknown)
        both = {name: value for name, value in given.items() if name not in (*flanks, *unknown)}
    result = dict.fromkeys(MODIFICATIONS.values())
    for flank, field in MODIFICATIONS.items():
        # A table for one flank replaces the table for both.
        values, where = (flanks[flank], f"{table}.{flank}") if flank in flanks else (both, table)
        result[field] = _read_modification(where, values, faults)
    if len(flanks) == len(MODIFICATIONS):  # replaced, but its faults are reported
        _read_modification(table, both, faults)
    return result


def _read_modification(table: str, given: object, faults: list[Fault]) -> Modification | None:
    """Read one table of amounts and lengths; None for an empty one."""
    if not isinstance(given, dict):
        faults.append(outside(table, "", "be a table", given, f"write [{table}] above its keys"))
        return None
    values = _checked(_MODIFICATION, table, given, faults)
    incomplete = [*missing_lengths(Modification, given), *missing_amounts(Modification, given)]
    faults += (fault._replace(table=table) for fault in incomplete)
    return Modification(**values) if values and not incomplete else None


def _read_tables(data: Mapping[str, object], faults: list[Fault]) -> dict[str, dict[str, Any]]:
    """Return the tables of a file by name; unknown and missing tables and other values are faults."""
    unknown = [name for name in data if name not in _TABLES]
    faults += [_unknown("", name, data[name]) for name in unknown]
    meant = {_guess(name, _TABLES) for name in unknown}
    tables: dict[str, dict[str, Any]] = {}
    for name in _TABLES:
        value = data.get(name, {})
        if not isinstance(value, dict):
            faults.append(outside(name, "", "be a table", value, f"write [{name}] above its keys"))
        elif name in data or (name in ("tool", "errors") and name not in meant):
            tables[name] = value
        elif name not in meant:
            faults.append(Fault(name, "", _MISSING))
    return tables


def _read_errors(given: Mapping[str, Any], faults: list[Fault]) -> Errors | MeshErrors | None:
    """Read [errors], about the common perpendicular or at the mesh, as the key `at` says."""
    keys, at = dict(given), given.get("at", "perpendicular")
    keys.pop("at", None)
    if not isinstance(at, str) or at not in _ERRORS_AT:
        limit = " or ".join(f'"{place}"' for place in _ERRORS_AT)
        cure = "it selects where errors are measured, the default is the common perpendicular"
        faults.append(outside("errors", "at", f"be {limit}", at, cure))
        return None
    values = _checked(_ERRORS_AT[at], "errors", keys, faults)
    if values is None:
        return None
    return from_degrees(MeshErrors, **values) if at == "mesh" else from_degrees(Errors, **values)


def _written_otherwise(text: str) -> list[Fault]:
    """Return faults of keys whose values have a decimal comma or a unit, in a text that is not valid TOML."""
    table = ""
    faults: list[Fault] = []
    for row in text.splitlines():
        if heading := re.match(r"\s*\[([\w.]+)\]", row):
            table = heading[1]
        entry = re.match(r"\s*(\w+)\s*=\s*([^#]*)", row)
        keys = _MODIFICATION if ".modification" in table else _TABLES.get(table, {})
        limit = keys.get(entry[1]) if entry else None
        if entry and limit and (cure := number_cure(entry[2].strip(), limit.unit)):
            faults.append(Fault(table, entry[1], refused("be a number", entry[2].strip(), cure)))
    return faults


def parse_design(text: str, source: str = "design", from_mesh: FromMesh | None = None) -> Design:
    """Return the design in a TOML text in mm and degrees.

    Parameters
    ----------
    text : str
        Content of a design file.
    source : str
        Name of the file, printed at the beginning of each line of an error message.
    from_mesh : callable, optional
        Conversion of errors at the mesh, see `FromMesh`; needed for at = "mesh" in [errors].

    Returns
    -------
    Design

    Raises
    ------
    DesignError
        With all faults.
    """
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        invalid = f"is not valid TOML: {' '.join(str(error).split())}"
        raise DesignError(_written_otherwise(text) or [invalid], source) from None
    faults: list[Fault] = []
    tables = _read_tables(data, faults)
    if "tool" in tables:
        # Keys that both members give may be missing in [tool].
        members = [tables[name] for name in ("pinion", "gear") if name in tables]
        supplied = {key for key in _TOOL if members and all(key in member for member in members)}
        _checked(_TOOL, "tool", tables["tool"], faults, _required(Tool) - supplied)
    pinion, gear = (
        _read_member(name, tables, faults) if name in tables else None for name in ("pinion", "gear")
    )
    pair: Pair | None = None
    errors: Errors | MeshErrors | None = None
    if "pair" in tables and (
        values := _checked(_TABLES["pair"], "pair", tables["pair"], faults, _required(Pair))
    ):
        pair = from_degrees(Pair, **values)
    if "errors" in tables:
        errors = _read_errors(tables["errors"], faults)
    if pinion and gear:
        faults += mesh_faults(pinion, gear)
    if pinion and pair and isinstance(errors, MeshErrors):
        faults += given_at_mesh_faults(pinion, pair, errors)
    if pinion and isinstance(errors, Errors):
        faults += offset_error_faults(pinion, errors)
    if pinion and gear and pair:
        faults += radian_faults(pinion, gear, pair)
        faults += parallel_faults(pinion, gear, pair)
        at: ErrorsAt = "mesh" if isinstance(errors, MeshErrors) else "perpendicular"
        if isinstance(errors, MeshErrors) and not faults:
            errors = _about_perpendicular(Design(pinion, gear, pair), errors, from_mesh, faults)
        if isinstance(errors, Errors) and not faults:
            return Design(pinion, gear, pair, errors, at)
    raise DesignError(dict.fromkeys(faults), source)


def _about_perpendicular(
    design: Design, errors: MeshErrors, from_mesh: FromMesh | None, faults: list[Fault]
) -> Errors:
    """Return the errors about the common perpendicular that are equivalent to errors at the mesh."""
    if from_mesh is None:
        raise TypeError("parse_design needs from_mesh for errors at the mesh")
    equivalent = from_mesh(design, errors)
    faults += mesh_error_faults(design.pinion, equivalent)
    return equivalent


def read_design_file(path: str | os.PathLike[str], from_mesh: FromMesh | None = None) -> Design:
    """Return the design in a file as `parse_design` does, or a built-in design by its name.

    Raises DesignError with all faults, or with the reason why the file cannot be read."""
    source = os.fspath(path)
    if source in BUILTINS:
        return builtin_design(source)
    try:
        text = read_text(source, MAX_FILE_BYTES)
    except TextFileError as error:
        raise DesignError([f"{error}: is it a design file?"], source) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        fault = f"cannot be read ({reason}): name a TOML file, or a built-in design: {_NAMES}"
        raise DesignError([fault], source) from None
    return parse_design(text, source, from_mesh)


def builtin_text(name: str = BUILTIN) -> str:
    """Return the text of a built-in design file. Raises DesignError for an unknown name."""
    if name not in BUILTINS:
        raise DesignError([f"there is no built-in design {shown_value(name)}: known are {_NAMES}"])
    return (resources.files(__package__) / "designs" / f"{name}.toml").read_text(encoding="utf-8")


def builtin_design(name: str = BUILTIN) -> Design:
    """Return a design that comes with the library.

    Parameters
    ----------
    name : str
        'ni-2017': the pair of Table 1 of the paper. 'awd-transfer' and 'marine-gearbox': intersecting axes.
        'anti-backlash': parallel axes.

    Returns
    -------
    Design

    Raises
    ------
    DesignError
        If there is no such design.

    Examples
    --------
    >>> from beveloid_geom import builtin_design
    >>> builtin_design("marine-gearbox").pinion.teeth
    24
    """
    return parse_design(builtin_text(name), name)


_OVERRIDES = {
    "offset_error": ("errors", "offset"),
    "shaft_angle_error_deg": ("errors", "shaft_angle_deg"),
    "pinion_axial_error": ("errors", "pinion_axial"),
    "gear_axial_error": ("errors", "gear_axial"),
} | {
    f"{key}_{member}": (member, key)
    for member in ("pinion", "gear")
    for key in ("parabola", *BY_FLANK, "parabola_apex")
}
"""Table and key of a file by argument of `override`."""


def override(
    design: Design,
    pinion_modification: Mapping[str, Any] | None = None,
    gear_modification: Mapping[str, Any] | None = None,
    **values: float | None,
) -> Design:
    """Return a single design with other assembly errors, parabola coefficients or modifications.

    Parameters
    ----------
    design : Design
        Design of plain numbers.
    pinion_modification, gear_modification : mapping, optional
        Keys of the table of the modification in a design file, with mappings for 'right' and 'left'. It
        replaces the modification of the member; an empty mapping removes it.
    **values : float or None
        New values in mm, deg and 1/mm, by the names `offset_error`, `shaft_angle_error_deg`,
        `pinion_axial_error`, `gear_axial_error`, and for the pinion `parabola_pinion` (both flanks),
        `parabola_right_pinion`, `parabola_left_pinion`, `parabola_apex_pinion`; likewise for the gear. None
        keeps the present value. The limits are those of a design file.

    Returns
    -------
    Design

    Raises
    ------
    DesignError
        With all faults, by argument.
    """
    arguments = {_OVERRIDES[name]: name for name, value in values.items() if value is not None}
    faults: list[Fault] = []
    changes: dict[str, dict[str, Any]] = {}
    for table in ("errors", "pinion", "gear"):
        given = {key: values[name] for (of, key), name in arguments.items() if of == table}
        changes[table] = _checked(_TABLES[table], table, given, faults) or {}
    changed = design.with_errors(replace(design.errors, **in_radians("Errors", changes["errors"])))
    changed = changed.with_parabola(*(changes[name].pop("parabola", None) for name in ("pinion", "gear")))
    for name in ("pinion", "gear"):  # values of one flank are applied to those of both flanks
        member = getattr(changed, name)
        changed = replace(changed, **{name: replace(member, tool=replace(member.tool, **changes[name]))})
    for name, amounts in (("pinion", pinion_modification), ("gear", gear_modification)):
        if amounts is not None:
            table, new = f"{name}.modification", list[Fault]()
            member = replace(getattr(changed, name), **_read_modifications(table, amounts, new))
            changed = replace(changed, **{name: member})
            for fault in new:  # the table of one flank is named in front of the key
                flank = fault.table.removeprefix(table).removeprefix(".")
                key = ".".join(filter(None, (flank, fault.key)))
                faults.append(Fault("", f"{name}_modification", f"{key} {fault.text}"))
    for name, member in (("pinion", changed.pinion), ("gear", changed.gear)):
        faults += member_faults(name, member)
    faults += offset_error_faults(changed.pinion, changed.errors)
    faults += parallel_faults(*changed.members, changed.pair)
    if faults:
        named = (Fault("", arguments[f[:2]], f.text) if f[:2] in arguments else f for f in faults)
        raise DesignError(dict.fromkeys(named))
    return changed
