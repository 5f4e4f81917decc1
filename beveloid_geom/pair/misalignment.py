"""Assembly errors of a study by their names, and designs with these errors.

The errors are either all about the common perpendicular, as in Fig. 5 of the paper (`ERROR_NAMES`), or all
at the mesh; axial errors are the same in both. All studies add errors to a design by `mounted`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from typing import TypeVar

import numpy as np

from ..arrays import FloatArray
from ..design.field_limits import LIMITS
from ..design.limits import MAX_OFFSET_ERROR_MODULES
from ..design.member import unchecked
from ..design.model import Design, Errors, ErrorsAt, MeshErrors
from .misalignment_at_mesh import at_mesh, from_mesh

Kind = TypeVar("Kind", Errors, MeshErrors)
ERROR_NAMES = tuple(field.name for field in fields(Errors))
NAMES: dict[ErrorsAt, tuple[str, ...]] = {
    "perpendicular": ERROR_NAMES,
    "mesh": tuple(field.name for field in fields(MeshErrors)),
}
"""Names of the errors of each kind, in the order of the last axis of all arrays of errors."""
ERROR_CLASSES: dict[ErrorsAt, type[Errors] | type[MeshErrors]] = {"perpendicular": Errors, "mesh": MeshErrors}
ANGLES = tuple(
    name
    for kind in ERROR_CLASSES.values()
    for name, one in LIMITS[kind.__name__].items()
    if one.unit == "deg"
)
ALL_NAMES = tuple(dict.fromkeys(ERROR_NAMES + NAMES["mesh"]))


def place_of(names: Sequence[str]) -> ErrorsAt:
    """Return the kind of errors with these names; axial errors alone are about the common perpendicular.

    Raises
    ------
    ValueError
        For unknown names, and for errors of both kinds.
    """
    if unknown := [name for name in names if name not in ALL_NAMES]:
        raise ValueError(f"unknown error {unknown[0]!r}: known are {', '.join(ALL_NAMES)}")
    for place, known in NAMES.items():
        if set(names) <= set(known):
            return place
    first, second = (
        next(name for name in names if name not in NAMES[place]) for place in ("mesh", "perpendicular")
    )
    raise ValueError(
        f"{first} is about the common perpendicular, {second} at the mesh: give two errors of the same kind"
    )


def mounted(design: Design, values: FloatArray, names: Sequence[str] = ERROR_NAMES) -> Design:
    """Return the design with additional errors, one case for each row of `values`.

    Parameters
    ----------
    design : Design
    values : ndarray, shape (..., names)
        Errors in mm and rad, added to those of the design. Errors at the mesh are added to the errors at the
        mesh that are equivalent to those of the design (`misalignment_at_mesh.at_mesh`).
    names : sequence of str
        Names of the errors.

    Returns
    -------
    Design
        Of the batch shape (...).

    Raises
    ------
    ValueError
        As in `place_of`.
    """
    if place_of(names) == "perpendicular":
        return design.with_errors(_sum(design.errors, names, values))
    return design.with_errors(from_mesh(design, _sum(at_mesh(design), names, values)))


def _sum(errors: Kind, names: Sequence[str], values: FloatArray) -> Kind:
    return unchecked(errors, **{name: getattr(errors, name) + values[..., k] for k, name in enumerate(names)})


def size_words(name: str, size: float) -> str:
    """Return the size of an error with its unit, mm or rad, and angles also in deg."""
    return f"{size:g} rad ({math.degrees(size):g} deg)" if name in ANGLES else f"{size:g} mm"


def errors_below(design: Design) -> dict[str, float]:
    """Return the upper limits of errors in a study of a single design, by their names.

    Limits of distances (mm) and of the error out of the plane (rad) are those of a design file. The limit of
    the error of the shaft angle and of the error in plane (rad) is the shaft angle of the pair, so that its
    sign does not change; on parallel axes it is that of a design file. Axial errors have no limit here.
    """
    # Limits of design files; the shaft angle must not change its sign.
    distance = MAX_OFFSET_ERROR_MODULES * float(design.pinion.tool.normal_module)
    angle = float(design.pair.shaft_angle) or float(np.radians(LIMITS["Errors"]["shaft_angle"].high))
    tilt = float(np.radians(LIMITS["MeshErrors"]["out_of_plane"].high))
    return {
        **{"offset": distance, "shaft_angle": angle},
        **{"centre_distance": distance, "in_plane": angle, "out_of_plane": tilt},
    }
