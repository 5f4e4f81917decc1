"""OpenGL for pictures: the tests of figures fail without it."""

from __future__ import annotations

import pytest

from beveloid_viz.rendering.opengl import require_opengl


@pytest.fixture(scope="session", autouse=True)
def _opengl() -> None:
    require_opengl()
