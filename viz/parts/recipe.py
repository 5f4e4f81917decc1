"""What a figure consists of: a computation, a drawing, and the numbers behind it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from beveloid_geom import Design

from ..stage import theme, typeset
from ..stage.layout import Layout
from ..stage.scene import Picture
from ..stage.theme import Page

Rows: TypeAlias = Iterator[Sequence[object]]
Table: TypeAlias = tuple[Sequence[str], Iterable[Sequence[object]]]
"""Header with units, and rows."""
Data = TypeVar("Data")


def stacked(cases: Iterable[Sequence[object]]) -> Rows:
    """Give the rows of cases, one under another: each column of a case, a list or array (n,), goes down its
    rows, and each single value stands in all of them; single values alone are one row."""
    for case in cases:
        cells = [cell.tolist() if isinstance(cell, np.ndarray) else cell for cell in case]
        count = max((len(cell) for cell in cells if isinstance(cell, list)), default=1)
        columns = (cell if isinstance(cell, list) else count * [cell] for cell in cells)
        yield from zip(*columns, strict=True)


def quantities(*lines: tuple[str, str, float]) -> Table:
    """Give a table of single numbers: name, unit and value of each."""
    return ("quantity", "unit", "value"), [(name, unit, float(value)) for name, unit, value in lines]


def vector(name: str, unit: str, values: Iterable[float]) -> Iterator[tuple[str, str, float]]:
    """Give lines of `quantities` for the components of a vector (3,), the place of its letter in the name
    {}."""
    return ((name.format(letter), unit, value) for letter, value in zip("xyz", values, strict=True))


@dataclass(frozen=True, eq=False)
class Drawing:
    """A finished page, the 3D pictures on it by name, and the triangles they took."""

    page: Page
    pictures: Mapping[str, Picture]

    @property
    def triangles(self) -> int:
        """Triangles in all pictures of the page."""
        return sum(picture.triangles for picture in self.pictures.values())


@dataclass(frozen=True)
class Recipe(Generic[Data]):
    """The three steps of a figure: `compute` solves and never draws, `draw` draws on a page laid out for it
    and never solves, `rows` are the numbers behind it."""

    compute: Callable[[Design], Data]
    draw: Callable[[Data, Layout], Drawing]
    rows: Callable[[Data], Table]

    def drawn(self, data: Data, layout: Layout) -> Drawing:
        """Draw the page to the end, in our style whatever the user's own is."""
        with theme.style():
            drawing = self.draw(data, layout)
            typeset.settle(drawing.page)
        return drawing
