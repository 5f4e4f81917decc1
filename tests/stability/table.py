"""The table "Where methods fail" of the README, made by running every method in every situation.

`python -m tests.stability.table` prints it.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from .outcomes import METHODS, Situation, in_a_cell, row_of
from .situations import SITUATIONS

HEADINGS = ("situation", *METHODS, "trusted", "the user is told")
PATHS = METHODS[:2]


class Row(NamedTuple):
    """A situation with the cell of each of METHODS and the words of the user."""

    situation: Situation
    cells: tuple[str, ...]
    told: str


@cache
def row(number: int) -> Row:
    """A situation, run; once."""
    cells, words = row_of(SITUATIONS[number])
    return Row(SITUATIONS[number], tuple(cells), in_a_cell(words))


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
