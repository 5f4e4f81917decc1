"""Pictures of what `beveloid_geom` computes: the figures of Ni et al. 2017, page, film, scenes of one's own.

Names below are loaded when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .parts.to_pyvista import to_pyvista as to_pyvista
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
__all__ = sorted((*_SCENE, "to_pyvista"))


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = "stage.scene" if name in _SCENE else "parts.to_pyvista"
    return getattr(import_module(f".{home}", __name__), name)
