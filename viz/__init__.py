"""Pictures of what `beveloid_geom` computes: the figures of Ni et al. 2017, page, film, scenes of one's own.

Names below are loaded when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .parts.to_pyvista import to_pyvista as to_pyvista
    from .stage.opengl import require_opengl as require_opengl
    from .stage.scene import (
        Arrow as Arrow,
        Camera as Camera,
        Paint as Paint,
        Picture as Picture,
        Scene as Scene,
        Surface as Surface,
        Tube as Tube,
        fit_camera as fit_camera,
        grid_surface as grid_surface,
        render as render,
    )

_SCENE = (
    "Arrow",
    "Camera",
    "Paint",
    "Picture",
    "Scene",
    "Surface",
    "Tube",
    "fit_camera",
    "grid_surface",
    "render",
)
_HOMES = dict.fromkeys(_SCENE, "stage.scene")
_HOMES |= {"require_opengl": "stage.opengl", "to_pyvista": "parts.to_pyvista"}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOMES[name]}", __name__), name)
