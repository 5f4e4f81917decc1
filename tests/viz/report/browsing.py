"""A report page opened in Chromium: messages, requests, pixels of the 3D view."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Page

FRAMES = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


@dataclass
class Seen:
    """A page with its messages and requests."""

    page: Page
    messages: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def picture(self) -> NDArray[np.int_]:
        """Return the pixels of the 3D view."""
        self.page.evaluate(FRAMES)
        png = self.page.locator("#view canvas").screenshot()
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)

    def camera(self) -> NDArray[np.float64]:
        return np.array(self.page.evaluate("pageView.camera()"))

    def roll(self) -> float:
        return float(self.page.evaluate("pageView.roll()"))

    def press(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).click()


def collect_messages(page: Page, messages: list[str]) -> None:
    """Collect the messages of a page: errors, and texts of the console. A message of
    the emulated WebGL is left out: that the browser waits while pixels are read."""

    def collect(message: ConsoleMessage) -> None:
        if "GPU stall due to ReadPixels" not in message.text:
            messages.append(f"{message.type}: {message.text}")

    page.on("pageerror", lambda error: messages.append(str(error)))
    page.on("console", collect)


@contextmanager
def opened(
    browser: Browser,
    report: Path,
    width: int = 640,
    script: str = "",
    *,
    folded: bool = False,
    **options: Any,
) -> Iterator[Seen]:
    """Open a report. Unless `folded`, all its sections are open and all patterns under errors are shown."""
    context = browser.new_context(viewport={"width": width, "height": 900}, **options)
    context.set_offline(True)
    seen = Seen(context.new_page())
    collect_messages(seen.page, seen.messages)
    seen.page.on("requestfailed", lambda request: seen.messages.append(f"failed: {request.url}"))
    seen.page.on("request", lambda request: seen.requests.append(request.url))
    if script:
        seen.page.add_init_script(script)
    seen.page.goto(report.as_uri())
    if not folded:
        seen.page.evaluate(
            "document.querySelectorAll('details.fold').forEach((fold) => { fold.open = true; })"
        )
        seen.page.locator("#all-cells").click()
    seen.page.locator("#view").scroll_into_view_if_needed()
    yield seen
    context.close()
    assert seen.messages == []
    assert seen.requests == [report.as_uri()]


def colours(picture: NDArray[np.int_]) -> int:
    return len(np.unique(picture.reshape(-1, 3), axis=0))


def differing(one: NDArray[np.int_], other: NDArray[np.int_]) -> float:
    """Return the fraction of pixels that differ visibly."""
    return float((np.abs(one - other).max(axis=-1) > 12).mean())
