"""The table "Where methods fail" of the README, made by running every method in every situation.

`python -m tests.stability.table` prints it.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from .outcomes import METHODS, Situation, cells_of, told_in
from .situations import SITUATIONS

HEADINGS = ("situation", *METHODS, "trusted", "the user is told")
PATHS = METHODS[:2]


class Row(NamedTuple):
    """A situation with the cell of each of METHODS."""

    situation: Situation
    cells: tuple[str, ...]

    @property
    def told(self) -> str:
        """The words of the user; they take as long as the cells, and are not asked for by all tests."""
        return _told(self.situation)


@cache
def row(number: int) -> Row:
    """A situation, run; once."""
    return Row(SITUATIONS[number], cells_of(SITUATIONS[number]))


@cache
def _told(situation: Situation) -> str:
    return told_in(situation)


def trusted(situation: Situation) -> str:
    names = situation.trusted
    if set(PATHS) <= set(names):
        names = ("both equations", *(name for name in names if name not in PATHS))
    return ", ".join("the status" if name == "status" else name for name in names)


def markdown() -> Iterator[str]:
    """The lines of the table as it stands in the README; each row is run when its turn comes."""
    yield f"| {' | '.join(HEADINGS)} |"
    yield f"| {' | '.join(['---'] * len(HEADINGS))} |"
    yield from (line(number) for number in range(len(SITUATIONS)))


def line(number: int) -> str:
    """A row of it."""
    found = row(number)
    cells = (found.situation.name, *found.cells, trusted(found.situation), found.told)
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    for text in markdown():
        print(text, flush=True)
