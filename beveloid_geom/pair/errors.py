"""Assembly errors of a study by their names, and the mountings with them.

Either all are about the common perpendicular, as the paper's Fig. 5 has them (`ERROR_NAMES`), or all at the
mesh (`MESH_ERROR_NAMES`); axial errors are the same in both. `mounted` is where all studies add errors to a
design, wherever they are measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import TypeVar

import numpy as np

from ..arrays import FloatArray
from ..design.field_limits import LIMITS
from ..design.limits import MOST_OFFSET_ERROR
from ..design.model import Design, Errors, ErrorsAt, MeshErrors, unchecked
from .mesh_errors import at_mesh, from_mesh

Kind = TypeVar("Kind", Errors, MeshErrors)
ERROR_NAMES = tuple(field.name for field in fields(Errors))
MESH_ERROR_NAMES = tuple(field.name for field in fields(MeshErrors))
NAMES: dict[ErrorsAt, tuple[str, ...]] = {"perpendicular": ERROR_NAMES, "mesh": MESH_ERROR_NAMES}
"""The errors of a place, in the order of all columns."""
KINDS: dict[ErrorsAt, type[Errors] | type[MeshErrors]] = {"perpendicular": Errors, "mesh": MeshErrors}
ANGLES = tuple(
    name for kind in KINDS.values() for name, one in LIMITS[kind.__name__].items() if one.unit == "deg"
)
ALL_NAMES = tuple(dict.fromkeys(ERROR_NAMES + MESH_ERROR_NAMES))


def place_of(names: Sequence[str]) -> ErrorsAt:
    """Say where errors of these names are measured; axial ones alone about the common perpendicular.

    Raises ValueError for other names, and for errors of both places."""
    if unknown := [name for name in names if name not in ALL_NAMES]:
        raise ValueError(f"there is no error {unknown[0]!r}: there are {', '.join(ALL_NAMES)}")
    for place, known in NAMES.items():
        if set(names) <= set(known):
            return place
    first, second = (
        next(name for name in names if name not in NAMES[place]) for place in ("mesh", "perpendicular")
    )
    raise ValueError(
        f"{first} is about the common perpendicular, {second} at the mesh: take errors of one place"
    )


def mounted(design: Design, values: FloatArray, names: Sequence[str] = ERROR_NAMES) -> Design:
    """Add errors (..., names), mm and rad, to those of a design: (...) mountings. At the mesh they are added
    to what those of the design are there (`pair.mesh_errors.at_mesh`). Raises ValueError as `place_of`."""
    if place_of(names) == "perpendicular":
        return design.with_errors(_sum(design.errors, names, values))
    return design.with_errors(from_mesh(design, _sum(at_mesh(design), names, values)))


def _sum(own: Kind, names: Sequence[str], values: FloatArray) -> Kind:
    return unchecked(own, **{name: getattr(own, name) + values[..., k] for k, name in enumerate(names)})


def errors_below(design: Design) -> dict[str, float]:
    """Give what errors of a study of a single design must stay below, by their names: of distances (mm) what
    a design file may have, of the shaft angle, at the mesh that in plane (rad), the pair's own, of parallel
    axes those of a file."""
    distance = MOST_OFFSET_ERROR * float(design.pinion.tool.normal_module)
    angle = float(design.pair.shaft_angle) or float(np.radians(LIMITS["Errors"]["shaft_angle"].high))
    tilt = float(np.radians(LIMITS["MeshErrors"]["out_of_plane"].high))
    return {
        **{"offset": distance, "shaft_angle": angle},
        **{"centre_distance": distance, "in_plane": angle, "out_of_plane": tilt},
    }
