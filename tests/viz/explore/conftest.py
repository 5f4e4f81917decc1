"""Servers of the tests, and Chromium; tests without the extra `explore` or Chromium are skipped."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

from beveloid_geom import Design, builtin_design
from tests.viz.report.conftest import browser as browser

if TYPE_CHECKING:
    from beveloid_viz.explore.notebook import Exploration


@pytest.fixture(scope="module")
def modified() -> Design:
    """Return Table 1 with the parabolas of the paper: contact on a flank and on an edge."""
    return builtin_design().with_parabola(0.001, -0.001)


@pytest.fixture(scope="module")
def explored() -> Iterator[Callable[..., Exploration]]:
    """Return a function that starts servers, which end with the module."""
    pytest.importorskip("aiohttp", reason="needs the extra `explore`")
    from beveloid_viz.explore import explore

    running: list[Exploration] = []

    def start(design: Design, **options: Any) -> Exploration:
        running.append(explore(design, **options))
        return running[-1]

    yield start
    for each in running:
        each.close()
