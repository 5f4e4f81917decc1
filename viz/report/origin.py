"""Origin of the numbers of a page."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime


@dataclass(frozen=True)
class Origin:
    """Name of a design as given, time of its file (None for a built-in design), whether options changed it,
    and time of the page."""

    name: str
    written: datetime | None
    changed: bool
    made: datetime
