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
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields, replace
from importlib import resources
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError, create_model
from pydantic_core import ErrorDetails, PydanticCustomError

from .field_limits import (
    FINITE,
    LIMITS,
    NUMBER,
    WHOLE,
    DesignError as DesignError,
    Fault,
    Limit,
    in_radians,
    shown_value,
)
from .limits import (
    layout_faults,
    member_faults,
    mesh_faults,
    outside,
    radian_faults,
)
from .model import Design, Errors, Member, Pair, Tool, from_degrees

BUILTIN = "ni-2017"
MOST_BYTES = 1_000_000
"""Of a design file; the built-in one has 2,000."""


class _Keys(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def _within(limit: Limit) -> AfterValidator:
    """The check of a key by its limit."""

    def check(value: float) -> float:
        if text := limit.fault(value):
            raise PydanticCustomError("range", "{text}", {"text": text})
        return value

    return AfterValidator(check)


def _keys_of(inputs: type) -> dict[str, Any]:
    """The quantities of a class of `design.model` as keys of a file, with pydantic's type and the default."""
    keys: dict[str, Any] = {}
    for field in fields(inputs):
        if limit := LIMITS[inputs.__name__].get(field.name):
            number: Any = Annotated[int if limit.whole else float, _within(limit)]
            key = field.name + ("_deg" if limit.unit == "deg" else "")
            default = ... if field.default is MISSING else field.default
            keys[key] = (number | None if limit.optional else number, default)
    return keys


_TOOL = _keys_of(Tool)
_PARABOLA = {"parabola": _TOOL.pop("parabola")}
_ToolKeys = create_model("_ToolKeys", __base__=_Keys, **_TOOL)
_ParabolaKeys = create_model("_ParabolaKeys", __base__=_Keys, **_PARABOLA)
_MemberKeys = create_model("_MemberKeys", __base__=_Keys, **_TOOL, **_PARABOLA, **_keys_of(Member))
_PairKeys = create_model("_PairKeys", __base__=_Keys, **_keys_of(Pair))
_ErrorKeys = create_model("_ErrorKeys", __base__=_Keys, **_keys_of(Errors))
_TABLES: dict[str, type[_Keys]] = {
    "tool": _ToolKeys,
    "pinion": _MemberKeys,
    "gear": _MemberKeys,
    "pair": _PairKeys,
    "errors": _ErrorKeys,
}
_TYPES = {"float_type": NUMBER, "int_type": WHOLE, "finite_number": FINITE}
_MISSING = "is missing: the built-in design shows all tables and keys"


def _guess(word: str, known: Iterable[str]) -> str | None:
    return next(iter(difflib.get_close_matches(word.lower(), list(known), n=1)), None)


def _unknown(table: str, key: str, value: object) -> Fault:
    """A key that `table` does not have; '' stands for the top of the file."""
    known = list(_TABLES[table].model_fields) if table else [f"[{name}]" for name in _TABLES]
    shown = key if re.fullmatch(r"[\w-]{1,40}", key) else shown_value(key)
    if isinstance(value, dict) and not table:
        shown = f"[{shown}]"
    elif homes := [f"[{name}]" for name, model in _TABLES.items() if key in model.model_fields]:
        return Fault(table, shown, f"does not belong here: move it to {' or '.join(homes)}")
    guess = _guess(shown, known)
    hint = f"did you mean {guess}?" if guess else f"there are {', '.join(known)}"
    return Fault(table, shown, f"is unknown: {hint}")


def _translated(table: str, error: ErrorDetails) -> Fault:
    """One of pydantic's errors in our words."""
    kind, value, key = error["type"], error["input"], str(error["loc"][0])
    if kind == "extra_forbidden":
        return _unknown(table, key, value)
    if kind == "missing":
        return Fault(table, key, _MISSING)
    if kind in _TYPES:
        limit, cure = _TYPES[kind]
        return outside(table, key, f"be {limit}", value, cure)
    return Fault(table, key, error["msg"])


K = TypeVar("K", bound=_Keys)


def _checked(model: type[K], table: str, values: Mapping[str, object], faults: list[Fault]) -> K | None:
    """The table as a model, or None and its faults added to `faults`."""
    try:
        return model.model_validate(dict(values))
    except ValidationError as error:
        details = error.errors(include_url=False)
    # A misspelt key is one mistake, not an unknown key and a missing one.
    meant = {_guess(str(d["loc"][0]), model.model_fields) for d in details if d["type"] == "extra_forbidden"}
    faults += [_translated(table, d) for d in details if d["type"] != "missing" or d["loc"][0] not in meant]
    return None


def _read_member(name: str, tables: dict[str, dict[str, Any]], faults: list[Fault]) -> Member | None:
    """A member with what it takes over from [tool], whose own faults are reported elsewhere."""
    own, shared = tables[name], tables.get("tool", {})
    inherited = {key: shared[key] for key in _ToolKeys.model_fields if key in shared and key not in own}
    found: list[Fault] = []
    keys = _checked(_MemberKeys, name, inherited | own, found)
    if keys is None:
        faults += [fault for fault in found if fault.key in own or fault.key not in _ToolKeys.model_fields]
        return None
    values, names = keys.model_dump(), {field.name for field in fields(Tool)}
    tool = {key: values.pop(key) for key in tuple(values) if key.removesuffix("_deg") in names}
    member = from_degrees(Member, tool=from_degrees(Tool, **tool), **values)
    for fault in member_faults(name, member):
        faults.append(fault._replace(table="tool") if fault.key in inherited else fault)
    return member


def _read_tables(data: Mapping[str, object], faults: list[Fault]) -> dict[str, dict[str, Any]]:
    """The tables of a file as far as they are tables; all else is a fault."""
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


def parse_design(text: str, source: str = "design") -> Design:
    """The design written in `text`, TOML in mm and degrees; `source` leads the error messages.

    Raises DesignError with every fault found."""
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise DesignError([f"is not valid TOML: {' '.join(str(error).split())}"], source) from None
    faults: list[Fault] = []
    tables = _read_tables(data, faults)
    if "tool" in tables:
        members = [tables[name] for name in ("pinion", "gear") if name in tables]
        supplied = {key for key in _ToolKeys.model_fields if members and all(key in own for own in members)}
        found: list[Fault] = []
        _checked(_ToolKeys, "tool", tables["tool"], found)
        faults += [fault for fault in found if fault.text != _MISSING or fault.key not in supplied]
    pinion, gear = (
        _read_member(name, tables, faults) if name in tables else None for name in ("pinion", "gear")
    )
    pair = errors = None
    if "pair" in tables and (keys := _checked(_PairKeys, "pair", tables["pair"], faults)):
        pair = from_degrees(Pair, **keys.model_dump())
    if "errors" in tables and (error_keys := _checked(_ErrorKeys, "errors", tables["errors"], faults)):
        errors = from_degrees(Errors, **error_keys.model_dump())
    if pinion and gear:
        faults += mesh_faults(pinion, gear)
    if pair and errors:
        faults += layout_faults(pair, errors)
    if pinion and gear and pair:
        faults += radian_faults(pinion, gear, pair)
        if errors and not faults:
            return Design(pinion, gear, pair, errors)
    raise DesignError(dict.fromkeys(faults), source)


def read_design(path: str | os.PathLike[str]) -> Design:
    """Read a design file (TOML, mm and degrees).

    Parameters
    ----------
    path : path-like
        The file, or 'ni-2017' for the built-in design.

    Returns
    -------
    Design
        In mm and rad.

    Raises
    ------
    DesignError
        With every fault found, or with the reason why there is no text.
    """
    source = os.fspath(path)
    if source == BUILTIN:
        return builtin_design()
    try:
        with open(source, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        fault = f"cannot be read ({reason}): name a TOML file, or '{BUILTIN}' for the built-in design"
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
    return parse_design(text, source)


def builtin_text(name: str = BUILTIN) -> str:
    """Text of the built-in design file, as a start for one's own. Raises DesignError."""
    if name != BUILTIN:
        raise DesignError([f"there is no built-in design {shown_value(name)}: there is '{BUILTIN}'"])
    return (resources.files(__package__) / "designs" / f"{name}.toml").read_text(encoding="utf-8")


def builtin_design(name: str = BUILTIN) -> Design:
    """Give a design that comes with the library.

    Parameters
    ----------
    name : str
        'ni-2017', the pair of Table 1, is the only one.

    Returns
    -------
    Design

    Raises
    ------
    DesignError
        For another name.
    """
    return parse_design(builtin_text(name), name)


def override(
    design: Design,
    *,
    offset_error: float | None = None,
    shaft_angle_error_deg: float | None = None,
    pinion_axial_error: float | None = None,
    gear_axial_error: float | None = None,
    parabola_pinion: float | None = None,
    parabola_gear: float | None = None,
) -> Design:
    """`design`, a single one, with other assembly errors (mm, deg) or parabolas (1/mm).

    None leaves a value as it is. The limits are those of a design file. Raises DesignError
    naming the arguments at fault."""
    given = {
        ("errors", "offset", "offset_error"): offset_error,
        ("errors", "shaft_angle_deg", "shaft_angle_error_deg"): shaft_angle_error_deg,
        ("errors", "pinion_axial", "pinion_axial_error"): pinion_axial_error,
        ("errors", "gear_axial", "gear_axial_error"): gear_axial_error,
        ("pinion", "parabola", "parabola_pinion"): parabola_pinion,
        ("gear", "parabola", "parabola_gear"): parabola_gear,
    }
    faults: list[Fault] = []
    changes: dict[str, dict[str, Any]] = {}
    for table, model in (("errors", _ErrorKeys), ("pinion", _ParabolaKeys), ("gear", _ParabolaKeys)):
        own = {key: value for (home, key, _), value in given.items() if home == table and value is not None}
        keys = _checked(model, table, own, faults)
        changes[table] = keys.model_dump(exclude_unset=True) if keys else {}
    changed = design.with_errors(replace(design.errors, **in_radians("Errors", changes["errors"])))
    changed = changed.with_parabola(changes["pinion"].get("parabola"), changes["gear"].get("parabola"))
    for name, member in (("pinion", changed.pinion), ("gear", changed.gear)):
        faults += member_faults(name, member)
    faults += layout_faults(changed.pair, changed.errors)
    names = {(table, key): name for (table, key, name), value in given.items() if value is not None}
    if faults:
        named = (Fault("", names[f[:2]], f.text) if f[:2] in names else f for f in faults)
        raise DesignError(dict.fromkeys(named))
    return changed
