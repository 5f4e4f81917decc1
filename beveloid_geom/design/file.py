"""Design files: TOML in mm and degrees, converted to the inputs of `model`.

The numbers of each table become keyword arguments of `from_degrees`. They are checked once, against the
limits of `field_limits`; combinations of keys are checked by `limits`. All faults are reported together, one
line each with key, limit, value and likely cure. Undercut, pointed teeth and backlash are not faults of a
file.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import resources
from typing import Any, TypeAlias

from ..support.text_file import TextFileError, read_text
from .field_limits import LIMITS, DesignError as DesignError, Fault, in_radians
from .keys import (
    ERRORS_AT,
    IS_MISSING,
    TABLES,
    checked_table,
    guess,
    keys_of,
    required_keys,
    unknown_key,
)
from .limits import (
    MIN_TIP_HEIGHT_MODULES,
    given_at_mesh_faults,
    member_faults,
    mesh_error_faults,
    mesh_faults,
    offset_error_faults,
    outside,
    parallel_faults,
    radian_faults,
    tip_cone_radius_at_mid_face,
)
from .member import BY_FLANK, Member, Tool
from .model import Design, Errors, ErrorsAt, MeshErrors, Pair, from_degrees
from .modification_file import (
    MODIFICATION_KEYS,
    ReadDeviations,
    file_key_faults,
    measured_member,
    modification_tables_of,
    read_modifications,
)
from .written_numbers import number_cure, refused, shown_value

BUILTIN = "ni-2017"
BUILTINS = {
    BUILTIN: "crossed pair of Table 1 of Ni et al. 2017: m 6, 29/45 teeth, offset 229 mm, 15 deg",
    "awd-transfer": "transfer pair for all-wheel drive: m 3, 37/37 teeth, intersecting axes, 4 deg",
    "marine-gearbox": "reduction of a marine gearbox: m 6, 24/61 teeth, intersecting axes, 7 deg",
    "anti-backlash": "backlash set by an axial shift: m 1.5, 24/72 straight teeth on cones, parallel axes",
}
"""Built-in designs by name, with a description."""
_NAMES = ", ".join(BUILTINS)
FromMesh: TypeAlias = Callable[[Design, MeshErrors], Errors]
"""`pair.misalignment_at_mesh.from_mesh`, which needs the pitch point of the design."""


def _read_member(
    name: str,
    tables: dict[str, dict[str, Any]],
    faults: list[Fault],
    folder: str,
    read_deviations: ReadDeviations | None,
) -> Member | None:
    """Read a member with the keys that it inherits from [tool].

    Faults of inherited keys are reported for [tool] only."""
    given, shared = dict(tables[name]), tables.get("tool", {})
    tables_by_flank = modification_tables_of(f"{name}.modification", given.pop("modification", {}), faults)
    modifications = read_modifications(tables_by_flank, faults)
    inherited = {key: shared[key] for key in TABLES["tool"] if key in shared and key not in given}
    new: list[Fault] = []
    values = checked_table(TABLES[name], name, inherited | given, new, required_keys(Tool, Member))
    if values is None:
        faults += [fault for fault in new if fault.key in given or fault.key not in TABLES["tool"]]
        return None
    tool = {key: values.pop(key) for key in keys_of(Tool) if key in values}
    diameter = values.pop("tip_diameter", None)
    member = from_degrees(Member, tool=from_degrees(Tool, **tool), **values, **modifications)
    if diameter is not None and "tip_alteration" in given:
        faults.append(
            Fault(name, "tip_diameter", "is given together with tip_alteration: remove one of them")
        )
        return None
    if diameter is not None:
        least, most = (
            float(f"{2.0 * float(tip_cone_radius_at_mid_face(replace(member, tip_alteration=k))):.6g}")
            for k in (MIN_TIP_HEIGHT_MODULES - member.tool.addendum, LIMITS["Member"]["tip_alteration"].high)
        )
        if not least <= diameter <= most:
            cure = "it is the diameter of the tip cone at mid-face and includes the profile shift"
            faults.append(outside(name, "tip_diameter", f"be between {least} and {most} mm", diameter, cure))
            return None
        member = member.with_tip_diameter(diameter)
    new = [
        fault._replace(table="tool") if fault.key in inherited else fault
        for fault in member_faults(name, member)
    ]
    faults += new
    return member if new else measured_member(member, tables_by_flank, faults, folder, read_deviations)


def _read_tables(data: Mapping[str, object], faults: list[Fault]) -> dict[str, dict[str, Any]]:
    """Return the tables of a file by name; unknown and missing tables and other values are faults."""
    unknown = [name for name in data if name not in TABLES]
    faults += [unknown_key("", name, data[name]) for name in unknown]
    meant = {guess(name, TABLES) for name in unknown}
    tables: dict[str, dict[str, Any]] = {}
    for name in TABLES:
        value = data.get(name, {})
        if not isinstance(value, dict):
            faults.append(outside(name, "", "be a table", value, f"write the line [{name}] above its keys"))
        elif name in data or (name in ("tool", "errors") and name not in meant):
            tables[name] = value
        elif name not in meant:
            faults.append(Fault(name, "", IS_MISSING))
    return tables


def _read_errors(given: Mapping[str, Any], faults: list[Fault]) -> Errors | MeshErrors | None:
    """Read [errors], about the common perpendicular or at the mesh, as the key `at` says."""
    keys, at = dict(given), given.get("at", "perpendicular")
    keys.pop("at", None)
    if not isinstance(at, str) or at not in ERRORS_AT:
        limit = " or ".join(f'"{place}"' for place in ERRORS_AT)
        cure = "it selects where errors are measured, the default is the common perpendicular"
        faults.append(outside("errors", "at", f"be {limit}", at, cure))
        return None
    values = checked_table(ERRORS_AT[at], "errors", keys, faults)
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
        keys = MODIFICATION_KEYS if ".modification" in table else TABLES.get(table, {})
        limit = keys.get(entry[1]) if entry else None
        if entry and limit and (cure := number_cure(entry[2].strip(), limit.unit)):
            faults.append(Fault(table, entry[1], refused("be a number", entry[2].strip(), cure)))
    return faults


def parse_design(
    text: str,
    source: str = "design",
    from_mesh: FromMesh | None = None,
    read_deviations: ReadDeviations | None = None,
) -> Design:
    """Return the design in a TOML text in mm and degrees.

    Parameters
    ----------
    text : str
        Content of a design file.
    source : str
        Name of the file, printed at the beginning of each line of an error message. Paths in the design are
        relative to its folder.
    from_mesh : callable, optional
        Conversion of errors at the mesh, see `FromMesh`; needed for at = "mesh" in [errors].
    read_deviations : callable, optional
        Reader of files of measured points, see `ReadDeviations`; needed for the key `deviations` of
        modifications.

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
        supplied = {key for key in TABLES["tool"] if members and all(key in member for member in members)}
        checked_table(TABLES["tool"], "tool", tables["tool"], faults, required_keys(Tool) - supplied)
    folder = os.path.dirname(source)
    pinion, gear = (
        _read_member(name, tables, faults, folder, read_deviations) if name in tables else None
        for name in ("pinion", "gear")
    )
    pair: Pair | None = None
    errors: Errors | MeshErrors | None = None
    if "pair" in tables and (
        values := checked_table(TABLES["pair"], "pair", tables["pair"], faults, required_keys(Pair))
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
    raise DesignError(faults, source)


def _about_perpendicular(
    design: Design, errors: MeshErrors, from_mesh: FromMesh | None, faults: list[Fault]
) -> Errors:
    """Return the errors about the common perpendicular that are equivalent to errors at the mesh."""
    if from_mesh is None:
        raise TypeError("parse_design needs the argument from_mesh for errors at the mesh")
    equivalent = from_mesh(design, errors)
    faults += mesh_error_faults(design.pinion, equivalent)
    return equivalent


def read_design_file(
    path: str | os.PathLike[str],
    from_mesh: FromMesh | None = None,
    read_deviations: ReadDeviations | None = None,
) -> Design:
    """Return the design in a file as `parse_design` does, or a built-in design by its name.

    Parameters
    ----------
    path : str or PathLike
        Design file, or name of a built-in design.
    from_mesh, read_deviations : callable, optional
        As in `parse_design`.

    Returns
    -------
    Design

    Raises
    ------
    DesignError
        With all faults, or with the reason why the file cannot be read.
    """
    # Largest size of a design file; the built-in ones have about 2,000 bytes.
    max_file_bytes = 1_000_000
    source = os.fspath(path)
    if source in BUILTINS:
        return builtin_design(source)
    try:
        text = read_text(source, max_file_bytes)
    except TextFileError as error:
        raise DesignError([f"{error}: is it a design file?"], source) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        fault = f"cannot be read ({reason}): give a design file, or a built-in design: {_NAMES}"
        raise DesignError([fault], source) from None
    return parse_design(text, source, from_mesh, read_deviations)


def builtin_text(name: str = BUILTIN) -> str:
    """Return the text of a built-in design file. Raises DesignError for an unknown name."""
    if name not in BUILTINS:
        raise DesignError([f"there is no built-in design {shown_value(name)}: give one of {_NAMES}"])
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
        changes[table] = checked_table(TABLES[table], table, given, faults) or {}
    changed = design.with_errors(replace(design.errors, **in_radians("Errors", changes["errors"])))
    changed = changed.with_parabola(*(changes[name].pop("parabola", None) for name in ("pinion", "gear")))
    for name in ("pinion", "gear"):  # values of one flank are applied to those of both flanks
        member = getattr(changed, name)
        changed = replace(changed, **{name: replace(member, tool=replace(member.tool, **changes[name]))})
    amounts = {"pinion": pinion_modification, "gear": gear_modification}
    given_amounts = {f"{name}.modification": keys for name, keys in amounts.items() if keys is not None}
    for table, keys in given_amounts.items():
        by_flank = modification_tables_of(table, keys, faults)
        faults += file_key_faults(by_flank)
        name = table.partition(".")[0]
        member = replace(getattr(changed, name), **read_modifications(by_flank, faults, others=()))
        changed = replace(changed, **{name: member})
    for name, member in (("pinion", changed.pinion), ("gear", changed.gear)):
        faults += member_faults(name, member)
    faults += offset_error_faults(changed.pinion, changed.errors)
    faults += parallel_faults(*changed.members, changed.pair)

    def named(fault: Fault) -> Fault:
        """Return the fault with the name of its argument."""
        table, dot, flank = fault.table.partition(".modification")
        if f"{table}{dot}" in given_amounts:  # the table of one flank is named in front of the key
            key = f"{flank}.{fault.key}".strip(".")
            return Fault("", f"{table}_modification", f"{key} {fault.text}".strip())
        return Fault("", arguments[fault[:2]], fault.text) if fault[:2] in arguments else fault

    if faults:
        raise DesignError(map(named, faults))
    return changed
