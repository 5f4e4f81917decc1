"""A design as the text of a design file: TOML in mm and degrees, which `file` reads."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from typing import Any

from .field_limits import LIMITS, in_radians
from .model import Design

WIDTH = 100
"""Characters of a line of the remark at the top."""


def design_text(design: Design, remark: str = "") -> str:
    """Write a single design as a file, with a `remark` at its top. Read again it has the same numbers, angles
    to the last digit; errors are those about the common perpendicular. Raises ValueError for arrays."""
    if design.batch_shape:
        raise ValueError(f"design must be a single one, got arrays of shape {design.batch_shape}")
    tables: dict[str, dict[str, Any]] = {}
    first, second = ({**vars(m.tool), **vars(m)} for m in design.members)
    shared = {key for key in LIMITS["Tool"] if key != "parabola" and first[key] == second[key]}
    tables["tool"] = {key: first[key] for key in LIMITS["Tool"] if key in shared}
    for name, own in (("pinion", first), ("gear", second)):
        tables[name] = {key: own[key] for key in (*LIMITS["Member"], *LIMITS["Tool"]) if key not in shared}
    tables["pair"] = {key: value for key, value in vars(design.pair).items() if value is not None}
    tables["errors"] = dict(vars(design.errors))
    head = textwrap.fill(remark, WIDTH, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False)
    lead = f"{head}\n# Lengths in mm, angles in degrees, right hand positive.\n" if remark else ""
    return lead + "\n".join("\n".join(_lines(name, values)) + "\n" for name, values in tables.items())


def _lines(name: str, values: dict[str, Any]) -> Iterator[str]:
    """Give the lines of a table."""
    limits = {key: limit for kind in LIMITS.values() for key, limit in kind.items()}
    yield f"[{name}]"
    for key, value in values.items():
        angle = limits[key].unit == "deg"
        yield f"{key}_deg = {_degrees(value)!r}" if angle else f"{key} = {value!r}"


def _degrees(angle: float) -> float:
    """Give an angle in deg, with fewer digits where these are read as the same."""
    short = float(f"{math.degrees(angle):.14g}")
    return (
        short
        if in_radians("Pair", {"shaft_angle_deg": short})["shaft_angle"] == angle
        else math.degrees(angle)
    )
