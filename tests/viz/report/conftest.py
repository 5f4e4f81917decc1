"""A report of the modified pair of the paper, and Chromium; tests without Chromium are skipped."""

from __future__ import annotations

import shutil
import subprocess
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from .browsing import Seen, opened

if TYPE_CHECKING:
    from playwright.sync_api import Browser

# As without a graphics card: Chromium draws pages by software, and emulates WebGL.
ARGUMENTS = (
    *("--no-sandbox", "--enable-unsafe-swiftshader", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
MODIFIED = ("--parabola-pinion", "0.001", "--parabola-gear", "-0.001")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("report") / "report.html"
    command = Path(sysconfig.get_path("scripts")) / "render-report"
    run = [str(command), "--out", str(out), "--cases", "200", *MODIFIED]
    subprocess.run(run, check=True, capture_output=True, timeout=300)
    return out


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    sync_api = pytest.importorskip("playwright.sync_api", reason="needs the extra `browser`")
    names = ("chromium", "chromium-browser", "google-chrome")
    chromium = next(filter(None, map(shutil.which, names)), None)
    if chromium is None:
        pytest.skip("needs chromium on the path (Debian's `chromium`)")
    with sync_api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=chromium, args=list(ARGUMENTS))
        yield launched
        launched.close()


@pytest.fixture(scope="module")
def seen(browser: Browser, report: Path) -> Iterator[Seen]:
    with opened(browser, report) as one:
        yield one
