"""The table "Where methods fail" of the README, made by running every method in every situation.

`python -m tests.stability.table` prints it.
"""

from __future__ import annotations

from functools import lru_cache
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


@lru_cache(maxsize=1)
def rows() -> tuple[Row, ...]:
    """All situations, run; once."""
    found = []
    for situation in SITUATIONS:
        cells, words = row_of(situation)
        found.append(Row(situation, tuple(cells), in_a_cell(words)))
    return tuple(found)


def trusted(situation: Situation) -> str:
    names = situation.trusted
    if set(PATHS) <= set(names):
        names = ("both equations", *(name for name in names if name not in PATHS))
    return ", ".join("the status" if name == "status" else name for name in names)


def markdown() -> str:
    """The table as it stands in the README."""
    lines = [HEADINGS, ("---",) * len(HEADINGS)]
    lines += [(row.situation.name, *row.cells, trusted(row.situation), row.told) for row in rows()]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    print(markdown())
