"""Tooth contact analysis of crossed beveloid gears with parabolic profile modification.

The house, from the ground up: `field_limits` -> `inputs` -> `rack` -> `flank` -> `assembly` -> `mounting` ->
`contact` -> `solve` -> `track` -> `follow` -> `path`; from there `fillet` -> `surface` -> `touch` ->
`first_contact` -> `certificate`, `operation`, `pattern` say what touches first, `sampling` ->
`proximity` do the same by meshes, and `outline` -> `section` -> `solid`, `hexahedra` -> `export`
make solids and files. `design_file` reads inputs from TOML, `closing` says how well a design
closes. Names below are loaded when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str
    from .backlash import backlash_by_errors as backlash_by_errors, mounted_backlash as mounted_backlash
    from .backlash_by_tangency import tangent_backlash as tangent_backlash
    from .certificate import certify as certify
    from .closing import (
        closing_of as closing_of,
        zero_backlash_layout as zero_backlash_layout,
    )
    from .conditioning import rounding_error as rounding_error
    from .contact import Limit as Limit
    from .curvature import contact_ellipse as contact_ellipse
    from .design_file import builtin_design as builtin_design, read_design as read_design
    from .design_map import DesignMap as DesignMap, map_of as map_of
    from .field_limits import DesignError as DesignError
    from .five_equations import (
        path_of_contact_five_equations as path_of_contact_five_equations,
        refine as refine,
    )
    from .flank import base_cylinder as base_cylinder, flank_patch as flank_patch, flank_point as flank_point
    from .hexahedra import tooth_hexahedra as tooth_hexahedra
    from .inputs import Design as Design, Errors as Errors, Member as Member, Pair as Pair, Tool as Tool
    from .layout_remarks import remarks_on as remarks_on
    from .mounting import mounting_of as mounting_of
    from .operation import mesh_cycle as mesh_cycle
    from .optimise import Aim as Aim, optimise_parabola as optimise_parabola
    from .path import (
        contact_ratio as contact_ratio,
        path_blocks as path_blocks,
        path_ends as path_ends,
        path_of_contact as path_of_contact,
    )
    from .pattern import contact_pattern as contact_pattern
    from .posing import meshing_pair as meshing_pair
    from .proximity import mesh_contact as mesh_contact, mesh_separation as mesh_separation
    from .ratio_in_operation import operating_ratio as operating_ratio
    from .sampling import sample_flank as sample_flank
    from .sensitivity import path_sensitivity as path_sensitivity
    from .sliding import least_sliding as least_sliding, sliding_of as sliding_of
    from .solid import gear_solid as gear_solid
    from .solve import Status as Status
    from .statements import paper_statements as paper_statements
    from .tolerance import Tolerances as Tolerances, tolerance_study as tolerance_study
    from .tooth import gear_mesh as gear_mesh
    from .touch import separation as separation
    from .undercut import undercut_of as undercut_of

_HOME = {
    "Aim": "optimise",
    "Design": "inputs",
    "DesignError": "field_limits",
    "DesignMap": "design_map",
    "Errors": "inputs",
    "Limit": "contact",
    "Member": "inputs",
    "Pair": "inputs",
    "Status": "solve",
    "Tolerances": "tolerance",
    "Tool": "inputs",
    "backlash_by_errors": "backlash",
    "base_cylinder": "flank",
    "builtin_design": "design_file",
    "certify": "certificate",
    "closing_of": "closing",
    "contact_ellipse": "curvature",
    "contact_pattern": "pattern",
    "contact_ratio": "path",
    "flank_patch": "flank",
    "flank_point": "flank",
    "gear_mesh": "tooth",
    "gear_solid": "solid",
    "least_sliding": "sliding",
    "map_of": "design_map",
    "mesh_contact": "proximity",
    "mesh_cycle": "operation",
    "mesh_separation": "proximity",
    "meshing_pair": "posing",
    "mounted_backlash": "backlash",
    "mounting_of": "mounting",
    "operating_ratio": "ratio_in_operation",
    "optimise_parabola": "optimise",
    "paper_statements": "statements",
    "path_blocks": "path",
    "path_ends": "path",
    "path_of_contact": "path",
    "path_of_contact_five_equations": "five_equations",
    "path_sensitivity": "sensitivity",
    "read_design": "design_file",
    "refine": "five_equations",
    "remarks_on": "layout_remarks",
    "rounding_error": "conditioning",
    "sample_flank": "sampling",
    "separation": "touch",
    "sliding_of": "sliding",
    "tangent_backlash": "backlash_by_tangency",
    "tolerance_study": "tolerance",
    "tooth_hexahedra": "hexahedra",
    "undercut_of": "undercut",
    "zero_backlash_layout": "closing",
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
