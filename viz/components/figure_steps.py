"""Parts of a figure: computation, drawing, and the table of its numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from ..rendering import theme, typeset
from ..rendering.layout import PageLayout
from ..rendering.scene import Picture
from ..rendering.theme import Page

Rows: TypeAlias = Iterator[Sequence[object]]
Table: TypeAlias = tuple[Sequence[str], Iterable[Sequence[object]]]
"""Column headings with units, and rows."""
Data = TypeVar("Data")


def rows_of_cases(cases: Iterable[Sequence[object]]) -> Rows:
    """Return the rows of several cases, one case after the other.

    Parameters
    ----------
    cases : iterable of sequence
        Columns of each case: a list or array (n,) with one value per row, or a single value, which is
        repeated in all rows of the case.

    Returns
    -------
    Rows
    """
    for case in cases:
        cells = [cell.tolist() if isinstance(cell, np.ndarray) else cell for cell in case]
        count = max((len(cell) for cell in cells if isinstance(cell, list)), default=1)
        columns = (cell if isinstance(cell, list) else count * [cell] for cell in cells)
        yield from zip(*columns, strict=True)


def quantities(*lines: tuple[str, str, float]) -> Table:
    """Return a table of single numbers.

    Parameters
    ----------
    *lines : tuple
        Name, unit and value of each number.

    Returns
    -------
    Table
    """
    return ("quantity", "unit", "value"), [(name, unit, float(value)) for name, unit, value in lines]


def vector(name: str, unit: str, values: Iterable[float]) -> Iterator[tuple[str, str, float]]:
    """Return the lines of `quantities` for the components of a vector (3,); {} in the name is replaced by x,
    y, z."""
    return ((name.format(letter), unit, value) for letter, value in zip("xyz", values, strict=True))


@dataclass(frozen=True, eq=False)
class Drawing:
    """Finished page, its 3D pictures by name, and their number of triangles."""

    page: Page
    pictures: Mapping[str, Picture]

    @property
    def triangles(self) -> int:
        """Number of triangles of all pictures."""
        return sum(picture.triangles for picture in self.pictures.values())


@dataclass(frozen=True)
class Recipe(Generic[Data]):
    """Steps of a figure.

    Attributes
    ----------
    compute : callable
        Computes the data from a design and, if the figure shows one flank, the flank. Does not draw.
    draw : callable
        Draws the data on a page. Does not compute.
    rows : callable
        Returns the table of the data.
    """

    compute: Callable[..., Data]
    draw: Callable[[Data, PageLayout], Drawing]
    rows: Callable[[Data], Table]

    def drawn(self, data: Data, layout: PageLayout) -> Drawing:
        """Draw and finish the page in our style, independent of the user's settings."""
        with theme.style():
            drawing = self.draw(data, layout)
            typeset.finish_page(drawing.page)
        return drawing
