"""Text of a design file from a design: TOML in mm and degrees, which `file` reads."""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from .arguments import require_single
from .field_limits import LIMITS, in_radians
from .member import MODIFICATIONS
from .model import Design


def design_text(design: Design, remark: str = "") -> str:
    """Return a single design as the text of a design file.

    Angles in deg have the digits that give the same numbers when the text is read again. Errors are written
    about the common perpendicular.

    Parameters
    ----------
    design : Design
        Design of plain numbers.
    remark : str
        Comment at the top of the file.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If the design has arrays, or measured deviations that were not read from a file or belong to other
        flanks.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> text = bg.design_text(bg.builtin_design("ni-2017"))
    >>> text.splitlines()[:2]
    ['[tool]', 'normal_module = 6.0']
    """
    require_single(design)
    for member in design.members:
        for measured in (one.deviations for one in member.modifications if one.deviations):
            if not all(measured.files):
                cure = "write the measured points to a file and read it"
                raise ValueError(f"deviations must come from a file that the design file can name: {cure}")
            # On reading, the points are compared with the flanks of the file.
            if measured.nominal != member.nominal():
                cure = "remove the deviations, or keep those flanks"
                text = "deviations belong to the flanks with which the points were compared, not to these"
                raise ValueError(f"{text}: {cure}")
    tables: dict[str, dict[str, Any]] = {}
    first, second = ({**vars(m.tool), **vars(m)} for m in design.members)
    tool = [key for key in LIMITS["Tool"] if not key.startswith("parabola")]
    shared = [key for key in tool if first[key] == second[key]]
    tables["tool"] = {key: first[key] for key in shared}
    for name, values, member in zip(("pinion", "gear"), (first, second), design.members, strict=True):
        member_keys = [*LIMITS["Member"], *(key for key in tool if key not in shared), *member.tool.parabolas]
        at_default = [key for key in ("tip_alteration", "parabola_apex") if not values[key]]
        tables[name] = {key: values[key] for key in (*member_keys, "parabola_apex") if key not in at_default}
        tables |= modification_tables(name, values)
    tables["pair"] = {key: value for key, value in vars(design.pair).items() if value is not None}
    tables["errors"] = dict(vars(design.errors))
    head = textwrap.fill(remark, 100, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False)
    lead = f"{head}\n# Lengths in mm, angles in degrees, right hand positive.\n" if remark else ""
    return lead + "\n".join("\n".join(_lines(name, values)) + "\n" for name, values in tables.items())


def modification_tables(name: str, member: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the tables of the modifications of a member by name, from the fields of the member.

    Deviations are represented by their file and its grid."""
    given = {flank: member[field] for flank, field in MODIFICATIONS.items()}
    rows = {flank: {} if one is None else one.given() for flank, one in given.items()}
    if rows["right"] == rows["left"]:
        rows = {"": rows["right"]}
    return {f"{name}.modification{flank and '.'}{flank}": row for flank, row in rows.items() if row}


def _lines(name: str, values: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of a table."""
    limits = {key: limit for kind in LIMITS.values() for key, limit in kind.items()}
    yield f"[{name}]"
    for key, value in values.items():
        angle = key in limits and limits[key].unit == "deg"
        yield f"{key}_deg = {_degrees(value)!r}" if angle else f"{key} = {_toml(value)}"


def _toml(value: Any) -> str:
    """Return a number, a text, a list or a table in the notation of TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(part)}" for key, part in value.items()) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def _degrees(angle: float) -> float:
    """Return an angle in deg, with 14 digits if they give the same angle when read again."""
    short = float(f"{math.degrees(angle):.14g}")
    return (
        short
        if in_radians("Pair", {"shaft_angle_deg": short})["shaft_angle"] == angle
        else math.degrees(angle)
    )
