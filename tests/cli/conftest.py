"""What a command prints in three forms is calculated once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path

import pytest

from beveloid_geom.design.file import builtin_text
from beveloid_geom.report import closing, ease_off, operation, path, pattern, sensitivity, sliding
from beveloid_geom.report.workshop import gear_data, shim


@pytest.fixture(autouse=True, scope="package")
def _reports_are_kept() -> Iterator[None]:
    """Reports of the same design, flank and options: a command asked for its JSON has them from its text."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (closing, ease_off, gear_data, operation, path, pattern, sensitivity, sliding, shim):
            name = f"{module.__name__.rpartition('.')[2]}_report".replace("path_", "contact_")
            patch.setattr(module, name, lru_cache(64)(getattr(module, name)))
        yield


@pytest.fixture
def design_file(tmp_path: Path) -> Callable[..., Path]:
    """Writes the built-in design with one piece of text replaced."""

    def write(old: str = "", new: str = "") -> Path:
        text = builtin_text()
        assert old in text
        path = tmp_path / "pair.toml"
        path.write_text(text.replace(old, new, 1) if old else text, encoding="utf-8")
        return path

    return write
