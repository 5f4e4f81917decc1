"""The table "Where methods fail" of the README, made by running every method in every situation.

`python -m tests.stability.table` prints it.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from .outcomes import METHODS, Situation, cells_of, message_in
from .situations import SITUATIONS

HEADINGS = ("situation", *METHODS, "trusted", "message to the user")
PATHS = METHODS[:2]


class Row(NamedTuple):
    """A situation with the cell of each of METHODS."""

    situation: Situation
    cells: tuple[str, ...]

    @property
    def message(self) -> str:
        """Message to the user. It takes as long to compute as the cells, and not all tests need it."""
        return _message(self.situation)


@cache
def row(number: int) -> Row:
    """Run a situation, once, and return its row."""
    return Row(SITUATIONS[number], cells_of(SITUATIONS[number]))


@cache
def _message(situation: Situation) -> str:
    return message_in(situation)


def trusted(situation: Situation) -> str:
    names = situation.trusted
    if set(PATHS) <= set(names):
        names = ("both equations", *(name for name in names if name not in PATHS))
    return ", ".join("the status" if name == "status" else name for name in names)


def markdown() -> Iterator[str]:
    """Return the lines of the table in the README; each row is run when it is reached."""
    yield f"| {' | '.join(HEADINGS)} |"
    yield f"| {' | '.join(['---'] * len(HEADINGS))} |"
    yield from (line(number) for number in range(len(SITUATIONS)))


def line(number: int) -> str:
    """Return a row of the table."""
    found = row(number)
    cells = (found.situation.name, *found.cells, trusted(found.situation), found.message)
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    for text in markdown():
        print(text, flush=True)
