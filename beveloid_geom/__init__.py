"""Tooth contact analysis of crossed beveloid gears with parabolic profile modification.

The house, from the ground up: `inputs` -> `rack` -> `flank` -> `assembly` -> `mounting` ->
`contact` -> `solve` -> `track` -> `path`. `design_file` reads inputs from TOML. Names below
are loaded when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOME = {
    "Design": "inputs",
    "DesignError": "design_file",
    "Errors": "inputs",
    "Limit": "contact",
    "Member": "inputs",
    "Pair": "inputs",
    "Status": "solve",
    "Tool": "inputs",
    "base_cylinder": "flank",
    "builtin_design": "design_file",
    "closing_of": "closing",
    "contact_ratio": "path",
    "flank_patch": "flank",
    "flank_point": "flank",
    "mounting_of": "mounting",
    "path_ends": "path",
    "path_of_contact": "path",
    "path_of_contact_five_equations": "five_equations",
    "read_design": "design_file",
    "remarks_on": "closing",
    "sample_flank": "sampling",
    "zero_backlash_layout": "closing",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
