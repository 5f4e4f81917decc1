"""Pictures of results of `beveloid_geom`: figures of Ni et al. 2017, report page, film, and scenes for
scripts.

The names below are imported on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .components.to_pyvista import to_pyvista as to_pyvista
    from .rendering.opengl import require_opengl as require_opengl
    from .rendering.scene import (
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

_SCENE = ("Arrow", "Camera", "Paint", "Picture", "Scene", "Surface", "Tube")
_MODULES = dict.fromkeys((*_SCENE, "fit_camera", "grid_surface", "render"), "rendering.scene")
_MODULES |= {"require_opengl": "rendering.opengl", "to_pyvista": "components.to_pyvista"}
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_MODULES[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
