"""Tables and keys of design files: limits by key, unknown and missing keys.

The numbers of each table become keyword arguments of `model.from_degrees`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields
from typing import Any

from .field_limits import LIMITS, Fault, FieldLimit, number_fault
from .member import Member, Tool
from .model import Errors, MeshErrors, Pair
from .written_numbers import shown_value


def keys_of(*inputs: type) -> dict[str, FieldLimit]:
    """Return the limits of input classes of `design` by key of a file; keys of angles end in `_deg`."""
    return {
        name + ("_deg" if limit.unit == "deg" else ""): limit
        for kind in inputs
        for name, limit in LIMITS[kind.__name__].items()
    }


def required_keys(*inputs: type) -> set[str]:
    """Return the keys of input classes of `design` that have no default."""
    names = {field.name for kind in inputs for field in fields(kind) if field.default is MISSING}
    return {key for key in keys_of(*inputs) if key.removesuffix("_deg") in names}


TABLES = {
    "tool": {key: limit for key, limit in keys_of(Tool).items() if not key.startswith("parabola")},
    **{
        name: {
            **keys_of(Tool, Member),
            "tip_diameter": FieldLimit(0.001, 1e6, "mm", "give the tip diameter at mid-face in mm"),
        }
        for name in ("pinion", "gear")
    },
    "pair": keys_of(Pair),
    "errors": keys_of(Errors),
}
"""Limits of the keys by table."""
ERRORS_AT = {"perpendicular": TABLES["errors"], "mesh": keys_of(MeshErrors)}
"""Keys of [errors] for each value of `at`."""
IS_MISSING = "is missing: `beveloid-geom design` prints a complete example"


def guess(word: str, known: Iterable[str]) -> str | None:
    """Return the known name that is most similar to a misspelt one."""
    return next(iter(difflib.get_close_matches(word.lower(), list(known), n=1)), None)


def unknown_key(table: str, key: str, value: object, keys: Iterable[str] = ()) -> Fault:
    """Return the fault of an unknown key of a table; the table is '' for keys above the first table."""
    names = {name: name for name in keys} if table else {name: f"[{name}]" for name in TABLES}
    known = list(names.values())
    shown = key if re.fullmatch(r"[\w-]{1,40}", key) else shown_value(key)
    if isinstance(value, dict) and not table:
        shown = f"[{shown}]"
    elif table == "errors" and (places := [at for at, keys_at in ERRORS_AT.items() if key in keys_at]):
        now = "without it" if places[0] == "mesh" else 'with at = "mesh"'  # "perpendicular" is the default
        return Fault(table, shown, f'needs at = "{places[0]}": {now}, the keys are {", ".join(known)}')
    elif tables := [f"[{name}]" for name, keys in TABLES.items() if key in keys]:
        return Fault(table, shown, f"does not belong here: move it to {' or '.join(tables)}")
    helix = shown.lower().replace("lead_", "helix_", 1)
    similar = helix if helix in names else guess(shown.strip("[]"), names)
    hint = f"did you mean {names[similar]}?" if similar else f"known are {', '.join(known)}"
    return Fault(table, shown, f"is unknown: {hint}")


def checked_table(
    known: Mapping[str, FieldLimit],
    table: str,
    given: Mapping[str, Any],
    faults: list[Fault],
    required: Iterable[str] = (),
    others: Iterable[str] = (),
) -> dict[str, Any] | None:
    """Return the numbers of a table, or None after adding its faults to `faults`.

    `others` are names of keys that are not numbers. The caller removes them from `given`; here they are only
    suggested for a misspelt key."""
    unknown = [key for key in given if key not in known]
    # A misspelt key is one mistake, not an unknown key and a missing one.
    meant = {guess(key, known) for key in unknown}
    new: list[Fault] = []
    for key, limit in known.items():
        if key in given and (text := number_fault(given[key], limit)):
            new.append(Fault(table, key, text))
        elif key not in given and key in required and key not in meant:
            new.append(Fault(table, key, IS_MISSING))
    new += [unknown_key(table, key, given[key], (*known, *others)) for key in unknown]
    faults += new
    return None if new else {key: given[key] for key in known if key in given}
