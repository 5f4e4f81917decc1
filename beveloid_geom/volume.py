"""A mesh of hexahedra with named sets, as finite element programs take it.

Nodes of an element stand in the order that Abaqus, CalculiX and VTK share: the lower face 0-1-2-3
against the clock seen from inside the element, above it 4-5-6-7; with 20 nodes, mid-side
nodes 8-11 on the edges of the lower face, 12-15 of the upper one, 16-19 between the two. Faces
are numbered as Abaqus has them: its S1 ... S6 are 0 ... 5 here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .inputs import FloatArray

Indices = NDArray[np.int64]

ELEMENT_FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
"""Corner nodes of the faces S1 ... S6, each seen from outside with the clock (inside: against)."""


@dataclass(frozen=True, eq=False)
class VolumeMesh:
    """Hexahedra of part of a gear, own frame.

    `points` (n, 3), mm; `hexahedra` (m, 8) or (m, 20), indices of points; `surfaces`: for each
    name an array (k, 2) of element index and face number 0 ... 5; `node_sets` and
    `element_sets`: sorted unique indices of points and of elements by name. The names are
    'right flank', 'left flank', 'right fillet', 'left fillet', 'tip', 'bottom', 'toe', 'heel',
    'bore', 'first side', 'last side'; with several teeth the sets hold those of all of them, and
    'right flank 1' ... those of each tooth."""

    points: FloatArray
    hexahedra: Indices
    surfaces: dict[str, Indices]
    node_sets: dict[str, Indices]
    element_sets: dict[str, Indices]
