"""Fixtures: cached reports, so that three output forms are computed once; design files with changes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path

import pytest

from beveloid_geom.design.file import builtin_text
from beveloid_geom.report import check, ease_off, operation, path, pattern, sensitivity, sliding
from beveloid_geom.report.workshop import gear_data, shim


@pytest.fixture(autouse=True, scope="module")
def _cached_reports() -> Iterator[None]:
    """Cache reports by design, flank and options."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (check, ease_off, gear_data, operation, path, pattern, sensitivity, sliding, shim):
            name = f"{module.__name__.rpartition('.')[2]}_report".replace("path_", "contact_")
            patch.setattr(module, name, lru_cache(64)(getattr(module, name)))
        yield


@pytest.fixture
def design_file(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes a built-in design with replaced and appended text."""

    def write(changes: Mapping[str, str] | None = None, more: str = "", name: str = "ni-2017") -> Path:
        text, path = builtin_text(name), tmp_path / "pair.toml"
        for old, new in (changes or {}).items():
            assert old in text
            text = text.replace(old, new, 1)
        path.write_text(text + more, encoding="utf-8")
        return path

    return write
