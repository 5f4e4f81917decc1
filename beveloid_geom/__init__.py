"""Tooth contact analysis of beveloid gears with parabolic profile modification.

Here are the names that most users need, loaded when first used::

    what is given       Design of two Member (each with its Tool), a Pair and Errors, in mm and rad, or
                        by from_degrees; builtin_design, read_design, zero_backlash_layout; DesignError
                        says what is wrong
    where flanks touch  path_of_contact(design, flank) is a ContactPath with a Status; contact_ratio,
                        sliding_of(path), pressure_along(path, Load(...))
    what touches first  certify(path), first_contact, mesh_cycle is a MeshCycle, contact_pattern,
                        mounted_backlash
    how flanks fit      ease_off(design, flank) is an EaseOff over the pinion's flank
    what errors do      path_sensitivity, tolerance_study within Tolerances, map_of, optimise_parabola
                        for an Aim
    shapes              sample_flank, gear_solid, tooth_hexahedra

All else is imported from its room. The rooms stand in the data's way, and each imports only from those
before it: `design` (what is given), `gear` (one gear), `pair` (how two stand to each other), `contact`
(where their flanks are tangent), `operation` (what touches first), `analysis` (what follows),
`workshop` (drawing, measuring room, shims), `shapes` and `export` (meshes and files), `reference` and
`studies` (the paper), `findings`, `report` and `cli` (words and commands). Each has a page of its own,
README.md.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str
    from .analysis.ease_off import EaseOff as EaseOff, ease_off as ease_off
    from .analysis.maps import map_of as map_of
    from .analysis.optimise import Aim as Aim, optimise_parabola as optimise_parabola
    from .analysis.pressure import Load as Load, pressure_along as pressure_along
    from .analysis.sensitivity import path_sensitivity as path_sensitivity
    from .analysis.sliding import sliding_of as sliding_of
    from .analysis.tolerance import Tolerances as Tolerances, tolerance_study as tolerance_study
    from .contact.path import (
        ContactPath as ContactPath,
        contact_ratio as contact_ratio,
        path_of_contact as path_of_contact,
    )
    from .design.field_limits import DesignError as DesignError
    from .design.file import builtin_design as builtin_design
    from .design.model import (
        Design as Design,
        Errors as Errors,
        Member as Member,
        MeshErrors as MeshErrors,
        Pair as Pair,
        Tool as Tool,
        from_degrees as from_degrees,
    )
    from .operation.backlash import mounted_backlash as mounted_backlash
    from .operation.certificate import certify as certify
    from .operation.first_contact import first_contact as first_contact
    from .operation.marking.pattern import contact_pattern as contact_pattern
    from .operation.mesh_cycle import MeshCycle as MeshCycle, mesh_cycle as mesh_cycle
    from .pair.closing import zero_backlash_layout as zero_backlash_layout
    from .pair.mesh_errors import read_design as read_design
    from .shapes.hexahedra import tooth_hexahedra as tooth_hexahedra
    from .shapes.sampling import sample_flank as sample_flank
    from .shapes.solid import gear_solid as gear_solid
    from .status import Status as Status

_ROOMS = {
    "analysis.ease_off": "EaseOff ease_off",
    "analysis.maps": "map_of",
    "analysis.optimise": "Aim optimise_parabola",
    "analysis.pressure": "Load pressure_along",
    "analysis.sensitivity": "path_sensitivity",
    "analysis.sliding": "sliding_of",
    "analysis.tolerance": "Tolerances tolerance_study",
    "contact.path": "ContactPath contact_ratio path_of_contact",
    "design.field_limits": "DesignError",
    "design.file": "builtin_design",
    "design.model": "Design Errors Member MeshErrors Pair Tool from_degrees",
    "operation.backlash": "mounted_backlash",
    "operation.certificate": "certify",
    "operation.first_contact": "first_contact",
    "operation.mesh_cycle": "MeshCycle mesh_cycle",
    "operation.marking.pattern": "contact_pattern",
    "pair.closing": "zero_backlash_layout",
    "pair.mesh_errors": "read_design",
    "shapes.hexahedra": "tooth_hexahedra",
    "shapes.sampling": "sample_flank",
    "shapes.solid": "gear_solid",
    "status": "Status",
}
"""The names by the module that has them."""
_HOME = {name: module for module, names in _ROOMS.items() for name in names.split()}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("beveloid-geom")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
