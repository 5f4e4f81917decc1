"""Design files: TOML in mm and degrees, read, checked and turned into inputs in mm and rad.

A file is checked once, here, and every fault is reported in one go, each on a line that
names key, limit, value and likely cure. Limits of single keys stand in `field_limits`.
Limits that join several keys stand in `design.limits`. How well a pair closes, undercut and
pointed teeth do not make a file faulty.
"""

from __future__ import annotations

import codecs
import difflib
import os
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, fields, replace
from importlib import resources
from typing import Any, NamedTuple, TypeAlias

from .field_limits import (
    LIMITS,
    DesignError as DesignError,
    Fault,
    Limit,
    in_radians,
    number_fault,
    shown_value,
)
from .limits import (
    given_at_mesh_faults,
    member_faults,
    mesh_error_faults,
    mesh_faults,
    offset_error_faults,
    outside,
    parallel_faults,
    radian_faults,
)
from .model import Design, Errors, ErrorsAt, Member, MeshErrors, Pair, Tool, from_degrees

BUILTIN = "ni-2017"
BUILTINS = {
    BUILTIN: "crossed pair of Table 1 of Ni et al. 2017: m 6, 29/45 teeth, offset 229 mm, 15 deg",
    "awd-transfer": "transfer pair for all-wheel drive: m 3, 37/37 teeth, axes that intersect at 4 deg",
    "marine-gearbox": "reduction of a marine gearbox: m 6, 24/61 teeth, axes that intersect at 7 deg",
    "anti-backlash": "backlash set by an axial shift: m 1.5, 24/72 straight teeth on cones, parallel axes",
}
"""Built-in designs by name, with what they are."""
_NAMES = ", ".join(BUILTINS)
MOST_BYTES = 1_000_000
"""Of a design file; the built-in one has 2,000."""


class _Key(NamedTuple):
    """A key of a table: its `limit`, and its `default`, MISSING where it must be given."""

    limit: Limit
    default: Any


_Keys: TypeAlias = Mapping[str, _Key]


def _keys_of(inputs: type) -> dict[str, _Key]:
    """Give the quantities of a class of `design.model` as keys of a file, those of angles with `_deg`."""
    limits = LIMITS[inputs.__name__]
    return {
        field.name + ("_deg" if limits[field.name].unit == "deg" else ""): _Key(
            limits[field.name], field.default
        )
        for field in fields(inputs)
        if field.name in limits
    }


_MEMBER, _ERRORS = _keys_of(Tool) | _keys_of(Member), _keys_of(Errors)
_ERRORS_AT: dict[ErrorsAt, _Keys] = {"perpendicular": _ERRORS, "mesh": _keys_of(MeshErrors)}
"""Keys of [errors] by the place `at` which they are: about the common perpendicular, or at the mesh."""
FromMesh: TypeAlias = Callable[[Design, MeshErrors], Errors]
"""`pair.mesh_errors.from_mesh`: it needs the pitch point, which follows from the design."""
_PARABOLA = {"parabola": _MEMBER["parabola"]}
_TOOL = {key: value for key, value in _keys_of(Tool).items() if key not in _PARABOLA}
_TABLES: dict[str, _Keys] = {
    "tool": _TOOL,
    "pinion": _MEMBER,
    "gear": _MEMBER,
    "pair": _keys_of(Pair),
    "errors": _ERRORS,
}
_MISSING = "is missing: the built-in design shows all tables and keys"


def _guess(word: str, known: Iterable[str]) -> str | None:
    return next(iter(difflib.get_close_matches(word.lower(), list(known), n=1)), None)


def _unknown(table: str, key: str, value: object, keys: Iterable[str] = ()) -> Fault:
    """Refuse a key that is not of those that `table` has; '' stands for the top of the file."""
    known = list(keys) if table else [f"[{name}]" for name in _TABLES]
    shown = key if re.fullmatch(r"[\w-]{1,40}", key) else shown_value(key)
    if isinstance(value, dict) and not table:
        shown = f"[{shown}]"
    elif table == "errors" and (places := [at for at, own in _ERRORS_AT.items() if key in own]):
        return Fault(table, shown, f'goes with at = "{places[0]}": here there are {", ".join(known)}')
    elif homes := [f"[{name}]" for name, keys in _TABLES.items() if key in keys]:
        return Fault(table, shown, f"does not belong here: move it to {' or '.join(homes)}")
    guess = _guess(shown, known)
    hint = f"did you mean {guess}?" if guess else f"there are {', '.join(known)}"
    return Fault(table, shown, f"is unknown: {hint}")


def _checked(
    known: _Keys, table: str, given: Mapping[str, Any], faults: list[Fault]
) -> dict[str, Any] | None:
    """Take the numbers of a table, defaults for keys that are left out; None, with its faults added to
    `faults`, where there are any."""
    unknown = [key for key in given if key not in known]
    # A misspelt key is one mistake, not an unknown key and a missing one.
    meant = {_guess(key, known) for key in unknown}
    values: dict[str, Any] = {}
    found: list[Fault] = []
    for key, (limit, default) in known.items():
        values[key] = given.get(key, default)
        if key in given and (text := number_fault(values[key], limit)):
            found.append(Fault(table, key, text))
        elif values[key] is MISSING and key not in meant:
            found.append(Fault(table, key, _MISSING))
    found += [_unknown(table, key, given[key], known) for key in unknown]
    faults += found
    return None if found else values


def _read_member(name: str, tables: dict[str, dict[str, Any]], faults: list[Fault]) -> Member | None:
    """Read a member with what it takes over from [tool], whose own faults are reported elsewhere."""
    own, shared = tables[name], tables.get("tool", {})
    inherited = {key: shared[key] for key in _TOOL if key in shared and key not in own}
    found: list[Fault] = []
    values = _checked(_MEMBER, name, inherited | own, found)
    if values is None:
        faults += [fault for fault in found if fault.key in own or fault.key not in _TOOL]
        return None
    names = {field.name for field in fields(Tool)}
    tool = {key: values.pop(key) for key in tuple(values) if key.removesuffix("_deg") in names}
    member = from_degrees(Member, tool=from_degrees(Tool, **tool), **values)
    for fault in member_faults(name, member):
        faults.append(fault._replace(table="tool") if fault.key in inherited else fault)
    return member


def _read_tables(data: Mapping[str, object], faults: list[Fault]) -> dict[str, dict[str, Any]]:
    """Read the tables of a file as far as they are tables; all else is a fault."""
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
    """Read [errors], about the common perpendicular or at the mesh."""
    keys, at = dict(given), given.get("at", "perpendicular")
    keys.pop("at", None)
    if not isinstance(at, str) or at not in _ERRORS_AT:
        limit = " or ".join(f'"{place}"' for place in _ERRORS_AT)
        cure = "it says where errors are measured, the common perpendicular if it is left out"
        faults.append(outside("errors", "at", f"be {limit}", at, cure))
        return None
    values = _checked(_ERRORS_AT[at], "errors", keys, faults)
    if values is None:
        return None
    return from_degrees(MeshErrors, **values) if at == "mesh" else from_degrees(Errors, **values)


def parse_design(text: str, source: str = "design", from_mesh: FromMesh | None = None) -> Design:
    """Read the design written in `text`, TOML in mm and degrees; `source` leads the error messages,
    `from_mesh` gives the errors about the common perpendicular of those at the mesh.

    Raises DesignError with every fault found."""
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise DesignError([f"is not valid TOML: {' '.join(str(error).split())}"], source) from None
    faults: list[Fault] = []
    tables = _read_tables(data, faults)
    if "tool" in tables:
        members = [tables[name] for name in ("pinion", "gear") if name in tables]
        supplied = {key for key in _TOOL if members and all(key in own for own in members)}
        found: list[Fault] = []
        _checked(_TOOL, "tool", tables["tool"], found)
        faults += [fault for fault in found if fault.text != _MISSING or fault.key not in supplied]
    pinion, gear = (
        _read_member(name, tables, faults) if name in tables else None for name in ("pinion", "gear")
    )
    pair: Pair | None = None
    errors: Errors | MeshErrors | None = None
    if "pair" in tables and (values := _checked(_TABLES["pair"], "pair", tables["pair"], faults)):
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
    """Give the errors about the common perpendicular for those at the mesh."""
    if from_mesh is None:
        raise TypeError("errors at the mesh are read by pair.mesh_errors.read_design")
    found = from_mesh(design, errors)
    faults += mesh_error_faults(design.pinion, found)
    return found


def read_design(path: str | os.PathLike[str], from_mesh: FromMesh | None = None) -> Design:
    """Read a design file (TOML, mm and degrees) as `parse_design` does, or a built-in one by its name.

    Raises DesignError with every fault found, or with the reason why there is no text."""
    source = os.fspath(path)
    if source in BUILTINS:
        return builtin_design(source)
    try:
        with open(source, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        fault = f"cannot be read ({reason}): name a TOML file, or a built-in design: {_NAMES}"
        raise DesignError([fault], source) from None
    if len(data) > MOST_BYTES:
        raise DesignError([f"is longer than {MOST_BYTES:,} bytes: is it a design file?"], source)
    # PowerShell's `>` writes UTF-16, and says so in its first two bytes.
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        fault = f"is not UTF-{16 if wide else 8} text (byte {error.start}): is it a design file?"
        raise DesignError([fault], source) from None
    return parse_design(text, source, from_mesh)


def builtin_text(name: str = BUILTIN) -> str:
    """Give the text of a built-in design file, as a start for one's own. Raises DesignError."""
    if name not in BUILTINS:
        raise DesignError([f"there is no built-in design {shown_value(name)}: there are {_NAMES}"])
    return (resources.files(__package__) / "designs" / f"{name}.toml").read_text(encoding="utf-8")


def builtin_design(name: str = BUILTIN) -> Design:
    """Give a design that comes with the library.

    Parameters
    ----------
    name : str
        'ni-2017', the pair of Table 1; 'awd-transfer' or 'marine-gearbox', on axes that intersect;
        'anti-backlash', on parallel ones.

    Returns
    -------
    Design

    Raises
    ------
    DesignError
        For another name.
    """
    return parse_design(builtin_text(name), name)


_OVERRIDES = {
    "offset_error": ("errors", "offset"),
    "shaft_angle_error_deg": ("errors", "shaft_angle_deg"),
    "pinion_axial_error": ("errors", "pinion_axial"),
    "gear_axial_error": ("errors", "gear_axial"),
    "parabola_pinion": ("pinion", "parabola"),
    "parabola_gear": ("gear", "parabola"),
}
"""Table and key of a file by the name that a value has as an argument."""


def override(design: Design, **values: float | None) -> Design:
    """`design`, a single one, with other assembly errors (mm, deg) or parabolas (1/mm), by the names of
    `_OVERRIDES`.

    None leaves a value as it is. The limits are those of a design file. Raises DesignError
    naming the arguments at fault."""
    names = {_OVERRIDES[name]: name for name, value in values.items() if value is not None}
    faults: list[Fault] = []
    changes: dict[str, dict[str, Any]] = {}
    for table, known in (("errors", _ERRORS), ("pinion", _PARABOLA), ("gear", _PARABOLA)):
        own = {key: values[name] for (home, key), name in names.items() if home == table}
        checked = _checked(known, table, own, faults) or {}
        changes[table] = {key: value for key, value in checked.items() if key in own}
    changed = design.with_errors(replace(design.errors, **in_radians("Errors", changes["errors"])))
    changed = changed.with_parabola(changes["pinion"].get("parabola"), changes["gear"].get("parabola"))
    for name, member in (("pinion", changed.pinion), ("gear", changed.gear)):
        faults += member_faults(name, member)
    faults += offset_error_faults(changed.pinion, changed.errors)
    faults += parallel_faults(*changed.members, changed.pair)
    if faults:
        named = (Fault("", names[f[:2]], f.text) if f[:2] in names else f for f in faults)
        raise DesignError(dict.fromkeys(named))
    return changed
