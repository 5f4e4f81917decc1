"""Where the numbers of a page come from."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True)
class Origin:
    """The `name` of a design as it was given, when its file was `written`, None for a built-in one, whether
    options `changed` it, and when the page was `made`."""

    name: str
    written: datetime | None
    changed: bool
    made: datetime
