"""Time from a slider event to the finished picture in Chromium, and its ratio to the calculation alone.

    OPENBLAS_NUM_THREADS=1 python -m pytest tests/benchmarks/test_explore_speed.py -m benchmark -s

Needs the extras `explore` and `browser`, and an idle machine: without a graphics card, Chromium draws with
the same cores. The time of the calculation is that of the same events, from the arrival of the values to the
end of the stage.
"""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from typing import TYPE_CHECKING

import pytest

from beveloid_geom import Design
from tests.viz.explore.conftest import browser as browser, explored as explored, modified as modified
from tests.viz.explore.test_explore_in_browser import window

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from beveloid_viz.explore.notebook import Exploration

pytestmark = pytest.mark.benchmark
EVENTS = 200
MAX_MS = {"motion": 90.0, "pattern": 150.0, "remarks": 150.0}
"""Largest median time from event to picture, by stage."""
MAX_BEYOND_MS = 60.0
"""Largest median time from event to picture beyond the calculation."""
TIMED = """async (count) => {
  const slider = document.querySelector("#value-offset_error ~ input"), rows = [];
  slider.step = "any"; // all values differ, so that no result is known from an earlier one
  for (let n = 0; n < count; n++) {
    const begin = performance.now(), row = {};
    slider.value = 0.05 * ((n * 0.382) % 1);
    await new Promise((done) => {
      const see = ({ detail }) => {
        if (detail.id !== detail.newest) return;
        row[detail.stage] = [performance.now() - begin, 1000 * detail.seconds];
        if (!detail.last) return;
        document.removeEventListener("explored", see);
        done();
      };
      document.addEventListener("explored", see);
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    });
    rows.push(row);
  }
  return rows;
}"""


def test_event_to_picture(browser: Browser, explored: Callable[..., Exploration], modified: Design) -> None:
    with window(browser, explored(modified).url) as page:
        rows = page.evaluate(TIMED, EVENTS)
    assert len(rows) == EVENTS
    print(f"\n{EVENTS} events, medians in ms")
    for stage in ("motion", "pattern", "remarks"):
        times = [row[stage] for row in rows]
        total, alone = (median(each[k] for each in times) for k in (0, 1))
        ratio, beyond = median(a / b for a, b in times), median(a - b for a, b in times)
        print(f"  {stage:8s} {total:6.0f}, calculation {alone:6.0f}, beyond {beyond:5.0f}, ratio {ratio:.2f}")
        assert total < MAX_MS[stage]
        assert beyond < MAX_BEYOND_MS
