"""Interactive view of a gear pair (`explore-pair`, and `explore` in a notebook)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .notebook import Exploration as Exploration, explore as explore

__all__ = ["Exploration", "explore"]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: the notebook view needs the extra `explore`."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import notebook

    return getattr(notebook, name)
