"""Designs kept by name and by explicit numbers: `named_designs.toml` and `paths_in_pieces.toml`."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path
from typing import Any

from beveloid_geom import Design, Errors, Member, Pair, Tool
from beveloid_geom.status import Limit
from tests.oracle.table1 import table1


@dataclass(frozen=True, eq=False)
class Named:
    """A design and the flank that is examined; the limits at which a path with several segments ends; a
    roll (rad)."""

    design: Design
    flank: Any
    ends: tuple[Limit, ...] = ()
    roll: float = 0.0


def read(name: str) -> dict[str, Any]:
    return tomllib.loads((Path(__file__).parent / name).read_text(encoding="utf-8"))


def named(row: dict[str, Any]) -> Named:
    def member(module: float, alpha: float, *rest: float) -> Member:
        *tool, teeth, helix, cone, shift, width = rest
        return Member(Tool(module, radians(alpha), *tool), teeth, radians(helix), radians(cone), shift, width)

    offset, shaft, *mounting = row["pair"]
    error, turned, *axial = row["errors"]
    pair, errors = Pair(offset, radians(shaft), *mounting), Errors(error, radians(turned), *axial)
    design = Design(member(*row["pinion"]), member(*row["gear"]), pair, errors)
    return Named(design, row["flank"], roll=row.get("roll", 0.0))


def in_pieces(row: dict[str, Any]) -> Named:
    design = table1(tuple(row["parabola"]), Errors(*row["errors"]))
    pinion, gear = (
        replace(member, face_width=face) for member, face in zip(design.members, row["faces"], strict=True)
    )
    ends = tuple(Limit[name] for name in row["ends"])
    return Named(replace(design, pinion=pinion, gear=gear), row["flank"], ends)


GROUPS = {
    group: {name: named(row) for name, row in rows.items()}
    for group, rows in read("named_designs.toml").items()
}
LOST, SECOND_PATH, OTHER, HARD = (GROUPS[name] for name in ("lost", "second_path", "other", "first_contact"))
CROSSING = {name: case.design for name, case in GROUPS["crossing"].items()}
"""Steep cones mounted so that n_x changes its sign on the flank."""
SPLIT = [in_pieces(row) for row in read("paths_in_pieces.toml")["pieces"]]
