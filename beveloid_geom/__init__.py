"""Tooth contact analysis of crossed beveloid gears with parabolic profile modification.

The rooms stand in the data's way, and each imports only from those before it: `design` (what is
given), `gear` (one gear), `pair` (how two stand to each other), `contact` (where their flanks are
tangent), `operation` (what touches first), `analysis` (what follows), `shapes` and `export` (meshes
and files), `reference` and `studies` (the paper), `report` and `cli` (words and commands). Each has
a page of its own, README.md. Names below are loaded when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str
    from .analysis.maps import DesignMap as DesignMap, map_of as map_of
    from .analysis.optimise import Aim as Aim, optimise_parabola as optimise_parabola
    from .analysis.sensitivity import path_sensitivity as path_sensitivity
    from .analysis.sliding import least_sliding as least_sliding, sliding_of as sliding_of
    from .analysis.tolerance import Tolerances as Tolerances, tolerance_study as tolerance_study
    from .contact.ellipse import contact_ellipse as contact_ellipse
    from .contact.path import (
        contact_ratio as contact_ratio,
        path_blocks as path_blocks,
        path_ends as path_ends,
        path_of_contact as path_of_contact,
    )
    from .contact.placing import meshing_pair as meshing_pair
    from .contact.rounding import rounding_error as rounding_error
    from .design.field_limits import DesignError as DesignError
    from .design.file import builtin_design as builtin_design, read_design as read_design
    from .design.model import Design as Design, Errors as Errors, Member as Member, Pair as Pair, Tool as Tool
    from .findings.layout import remarks_on as remarks_on
    from .gear.flank import (
        base_cylinder as base_cylinder,
        flank_patch as flank_patch,
        flank_point as flank_point,
    )
    from .gear.undercut import undercut_of as undercut_of
    from .operation.backlash import (
        backlash_by_errors as backlash_by_errors,
        mounted_backlash as mounted_backlash,
    )
    from .operation.backlash_by_tangency import tangent_backlash as tangent_backlash
    from .operation.certificate import certify as certify
    from .operation.mesh_cycle import mesh_cycle as mesh_cycle
    from .operation.operating_ratio import operating_ratio as operating_ratio
    from .operation.pattern import contact_pattern as contact_pattern
    from .operation.separation import separation as separation
    from .pair.closing import (
        closing_of as closing_of,
        zero_backlash_layout as zero_backlash_layout,
    )
    from .pair.mounting import mounting_of as mounting_of
    from .reference.five_equations import (
        path_of_contact_five_equations as path_of_contact_five_equations,
        refine as refine,
    )
    from .shapes.hexahedra import tooth_hexahedra as tooth_hexahedra
    from .shapes.mesh_contact import mesh_contact as mesh_contact, mesh_separation as mesh_separation
    from .shapes.sampling import sample_flank as sample_flank
    from .shapes.solid import gear_solid as gear_solid
    from .shapes.surface_mesh import gear_mesh as gear_mesh
    from .status import Limit as Limit, Status as Status
    from .studies.statements import paper_statements as paper_statements

_HOME = {
    "Aim": "analysis.optimise",
    "Design": "design.model",
    "DesignError": "design.field_limits",
    "DesignMap": "analysis.maps",
    "Errors": "design.model",
    "Limit": "status",
    "Member": "design.model",
    "Pair": "design.model",
    "Status": "status",
    "Tolerances": "analysis.tolerance",
    "Tool": "design.model",
    "backlash_by_errors": "operation.backlash",
    "base_cylinder": "gear.flank",
    "builtin_design": "design.file",
    "certify": "operation.certificate",
    "closing_of": "pair.closing",
    "contact_ellipse": "contact.ellipse",
    "contact_pattern": "operation.pattern",
    "contact_ratio": "contact.path",
    "flank_patch": "gear.flank",
    "flank_point": "gear.flank",
    "gear_mesh": "shapes.surface_mesh",
    "gear_solid": "shapes.solid",
    "least_sliding": "analysis.sliding",
    "map_of": "analysis.maps",
    "mesh_contact": "shapes.mesh_contact",
    "mesh_cycle": "operation.mesh_cycle",
    "mesh_separation": "shapes.mesh_contact",
    "meshing_pair": "contact.placing",
    "mounted_backlash": "operation.backlash",
    "mounting_of": "pair.mounting",
    "operating_ratio": "operation.operating_ratio",
    "optimise_parabola": "analysis.optimise",
    "paper_statements": "studies.statements",
    "path_blocks": "contact.path",
    "path_ends": "contact.path",
    "path_of_contact": "contact.path",
    "path_of_contact_five_equations": "reference.five_equations",
    "path_sensitivity": "analysis.sensitivity",
    "read_design": "design.file",
    "refine": "reference.five_equations",
    "remarks_on": "findings.layout",
    "rounding_error": "contact.rounding",
    "sample_flank": "shapes.sampling",
    "separation": "operation.separation",
    "sliding_of": "analysis.sliding",
    "tangent_backlash": "operation.backlash_by_tangency",
    "tolerance_study": "analysis.tolerance",
    "tooth_hexahedra": "shapes.hexahedra",
    "undercut_of": "gear.undercut",
    "zero_backlash_layout": "pair.closing",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("beveloid-geom")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
