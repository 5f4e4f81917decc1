"""Structured hexahedra of one or more teeth with their part of the body.

The quadrilaterals of the transverse section (`section`), the same at all stations along the face,
make layers of hexahedra. Nodes of the outline stand on the surfaces that the tool cuts; nodes
of the bore on its cylinder. Of an element with 20 nodes the mid-side nodes stand there too, on
edges along the face all of them in the section half a station on, and inside a section in
the middle of their edges.

Sizes follow from a tolerance: elements are as large as they may be to keep it with 8 nodes. Those
with 20 nodes are as large, but have curved edges and come much closer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, Indices
from ..design.model import Member
from .elements import VolumeMesh, element_shapes, face_nodes
from .outline import counted, cut_sheets, require_tolerance
from .sampling import Sheet, SheetGrid, form_of, grid_of, stations
from .section import SIDES, Section, section_of, section_size
from .solid import NAMES, bore_of, joined_numbers, surface_name, teeth_with, turned

ELEMENTS = {"C3D20": 20, "C3D20R": 20, "C3D8I": 8, "C3D8": 8}
"""Nodes of the elements, by Abaqus's names."""
MAX_NODES = 5_000_000
ASPECT, GROWTH = 8.0, 1.4
"""Of the body's rows, see `section.section_of`; the flank's rows grow like them from the fillet on."""
STRETCHED_FOR = 0.01
"""Tolerance (mm) for which stations along a profile are stretched."""
LEAST = 4
"""Elements along a fillet and across a tooth, at least."""
COARSER, SLENDER = 2.5, 8.0
"""Elements of the flank and across the tooth are this many times as large as those of the fillet,
and along the face as long."""
FINEST = 0.08
"""Modules: smaller elements of a short fillet do not make the others smaller."""
PROBE, PASSES, MANY = 8, 2, 300
"""Elements in each direction of the surfaces that are measured first; numbers so found are measured
again, if they are not that many already."""
FINE = 400
"""Steps in which lengths along a profile are measured."""
LEAST_SHAPE = 0.2
"""Of the scaled Jacobian and of the ratio of determinants, see `volume.element_shapes`."""
CENTRING = 6
"""Steps that bring mid-side nodes over the middle of their edges."""
SHAPE_CURE = "take a smaller tolerance, another bore_radius, or a tool with a larger tip_radius"
GRADED = 0.5
"""Columns of the tooth are narrower by this share at its flanks than on average, wider inside."""


@dataclass(frozen=True)
class Cells:
    """Numbers of elements: along each half of the `bottom` land, each `fillet` (two or more) and
    each `flank`, across the `tip`, along the `face`."""

    bottom: int
    fillet: int
    flank: int
    tip: int
    face: int


def cells_of(member: Member, tolerance: float) -> Cells:
    """Count the elements whose faces with 4 nodes stay within `tolerance` (mm) of the surfaces; flank, bottom
    and tooth are divided so that sizes do not jump at the fillet, where elements are least.

    Raises ValueError as `cut_sheets` does, and for a tolerance below LEAST_TOLERANCE."""
    require_tolerance(tolerance)
    sheets, cells = cut_sheets(member), Cells(PROBE, PROBE, PROBE, PROBE, PROBE)
    for _ in range(PASSES):
        cells = _scaled(member, sheets, cells, tolerance)
        if max(vars(cells).values()) > MANY:
            break
    return cells


def _scaled(member: Member, sheets: dict[str, Sheet], measured: Cells, tolerance: float) -> Cells:
    """Count the elements that keep half the tolerance along profiles and half along the face, if distances
    fall with the square of their number from what is measured."""
    off = _deviations(sheets, measured)
    rows, length = dict.fromkeys(("bottom", "fillet", "flank", "tip"), 1), dict.fromkeys(sheets, 0.0)
    for name, sheet in sheets.items():
        kind = name.split()[-1]
        rows[kind] = max(
            rows[kind], _count(getattr(measured, kind) * np.sqrt(2.0 * off[name][0] / tolerance))
        )
        length[name] = float(_lengths(sheet)[1][-1])
    longest = {kind: max(length[name] for name in length if name.endswith(kind)) for kind in rows}
    fillet = max(rows["fillet"], LEAST)
    step = max(longest["fillet"] / fillet, FINEST * float(member.tool.normal_module))
    z = sheets["tip"].half_width * np.linspace(-1.0, 1.0, 9)
    left, right = (
        grid_of(sheets[f"{side} flank"], np.array([0.0, 1.0]), z).points for side in ("left", "right")
    )
    thickness = float(np.linalg.norm(left[0] - right[0], axis=-1).max())
    along = float(max(np.linalg.norm(np.diff(side[1], axis=0), axis=-1).sum() for side in (left, right)))
    face = measured.face * np.sqrt(2.0 * max(both[1] for both in off.values()) / tolerance)
    return Cells(
        bottom=max(rows["bottom"], _count(longest["bottom"] / (1.5 * step))),
        fillet=fillet,
        flank=max(rows["flank"], 1 + _count(longest["flank"] / (COARSER * step))),
        tip=max(rows["tip"], LEAST, _count(thickness / (COARSER * step))),
        face=max(_count(face), _count(along / (SLENDER * step))),
    )


def _count(number: float) -> int:
    return max(1, int(np.ceil(number - 1e-9)))


def _deviations(sheets: dict[str, Sheet], cells: Cells) -> dict[str, tuple[float, float]]:
    """Find the greatest distances (mm) of straight edges from each surface, along its profile and the
    face; of a face with 4 nodes at most their sum."""
    z = sheets["tip"].half_width * np.linspace(-1.0, 1.0, 2 * cells.face + 1)
    found = {}
    for name, grid in _grids(sheets, cells, z).items():
        both = []
        for axes in ((0, 1, 2), (1, 0, 2)):
            points, normals = grid.points.transpose(axes), grid.normals.transpose(axes)[1::2]
            off = 0.5 * (points[:-2:2] + points[2::2]) - points[1::2]
            both.append(float(np.abs(np.einsum("...i,...i", off, normals)).max()))
        found[name] = both[0], both[1]
    return found


def tooth_hexahedra(
    member: Member,
    teeth: int | None = 1,
    element: str = "C3D20",
    tolerance: float = 0.05,
    bore_radius: float | None = None,
    cells: Cells | Sequence[Cells] | None = None,
) -> VolumeMesh:
    """Mesh some teeth of a gear with hexahedra, in the own frame.

    Parameters
    ----------
    member : Member
        A single one.
    teeth : int, optional
        Number of neighbouring teeth, as in `gear_solid`; all (None) are the whole gear, without sides.
    element : {'C3D20', 'C3D20R', 'C3D8I', 'C3D8'}
        With 20 or 8 nodes. The reduced integration of C3D20R leaves hourglass modes under a load on one
        face, and C3D8I fails the patch test where elements are no parallelepipeds.
    tolerance : float
        mm; sets the number of elements as `cells_of` has it.
    bore_radius : float, optional
        mm; 0.45 of the root radius unless given.
    cells : Cells or a sequence of them, optional
        Numbers of elements, in place of `tolerance`; those of each of the teeth may differ in the flank's.

    Returns
    -------
    VolumeMesh

    Raises
    ------
    ValueError
        For a number of teeth the gear has not, more than MAX_NODES, elements out of shape (LEAST_SHAPE),
        cells that do not fit to those of the next tooth, and as `cut_sheets`, `bore_of` and `section_of`.
    """
    if element not in ELEMENTS:
        raise ValueError(f"element must be one of {', '.join(ELEMENTS)}, got {element!r}")
    count = int(member.teeth)
    if teeth is not None and not 0 < teeth <= count:
        raise ValueError(f"teeth must be between 1 and {count}, got {teeth}")
    wanted = count if teeth is None else teeth
    cells = cells_of(member, tolerance) if cells is None else cells
    each = [cells] * wanted if isinstance(cells, Cells) else list(cells)
    if len(each) != wanted or len({replace(one, flank=1) for one in each}) > 1:
        raise ValueError(f"cells must be given for {counted(wanted)}, equal but for the flank, got {each}")
    bore, teeth_of = bore_of(member, bore_radius), {}
    for numbers in set(each):
        tooth = _tooth(member, numbers, ELEMENTS[element] == 20, bore, wanted)
        _require_shape(VolumeMesh(tooth.points, tooth.hexahedra, {}, {}, {}))
        teeth_of[numbers] = tooth
    return _joined([teeth_of[numbers] for numbers in each], count)


def _tooth(member: Member, cells: Cells, quadratic: bool, bore: float, teeth: int) -> _Tooth:
    """Mesh one tooth of so many cells. Raises ValueError for numbers below 1, and where `teeth` of
    them take too many nodes."""
    for name, number in vars(cells).items():
        if number < 1:
            raise ValueError(f"cells must be 1 or more, got {name}={number}")
    sheets, half = cut_sheets(member), 0.5 * float(member.face_width)
    _require_size((cells.tip * (cells.flank + cells.fillet),) * 2, cells.face, quadratic, teeth)
    size = section_size(_corners(_outline(sheets, cells, np.zeros(1))), bore, ASPECT, GROWTH)
    _require_size(size, cells.face, quadratic, teeth)
    outline = _outline(sheets, cells, np.linspace(-half, half, 2 * cells.face + 1))
    section = section_of(_corners(outline), bore, ASPECT, GROWTH)
    return _quadratic(section, outline, bore) if quadratic else _linear(section)


def _require_shape(mesh: VolumeMesh) -> None:
    """Raise ValueError for elements that are turned over or too distorted."""
    scaled, ratio = (float(values.min()) for values in element_shapes(mesh))
    if not min(scaled, ratio) >= LEAST_SHAPE:
        text = (
            f"scaled Jacobian {scaled:.2f}, ratio of determinants {ratio:.2f}, the least is {LEAST_SHAPE:g}"
        )
        raise ValueError(f"some elements are too distorted ({text}): {SHAPE_CURE}")


def _outline(sheets: dict[str, Sheet], cells: Cells, z: FloatArray) -> dict[str, FloatArray]:
    """Give the curves (2 k + 1, nz, 3) around the tooth, of corners and mid-side nodes in turn."""
    found = {}
    for name, grid in _grids(sheets, cells, z).items():
        points = _centred(sheets[name], grid)
        found[name] = points[::-1] if name.startswith("right") else points
    return found


def _centred(sheet: Sheet, grid: SheetGrid) -> FloatArray:
    """Give the points (2 k + 1, nz, 3) of a grid, every other row moved on the surface to over the middle
    of the edge between its neighbours: the stations are those of mid-face, and a flank that is next to
    undercut at its toe stretches from there."""
    points, ends = grid.points.copy(), grid.parameter[::2]
    edge, at = points[2::2] - points[:-2:2], grid.parameter[1::2]
    z = np.broadcast_to(grid.z, at.shape)
    for _ in range(CENTRING):
        way = points[1::2] - points[:-2:2]
        share = np.einsum("...i,...i", way, edge) / np.einsum("...i,...i", edge, edge)
        at = at + (0.5 - share) * np.diff(ends, axis=0)
        points[1::2] = sheet.place(at, z)[0]
    return points


def _grids(sheets: dict[str, Sheet], cells: Cells, z: FloatArray) -> dict[str, SheetGrid]:
    """Give the surfaces at the stations of corners and, half-way between them, of mid-side nodes."""
    grids = {}
    for name, sheet in sheets.items():
        side, kind = name.split()[0], name.split()[-1]
        number = getattr(cells, kind)
        s, length = _lengths(sheet)
        if kind == "tip":
            even = np.linspace(0.0, 1.0, number + 1)
            at = length[-1] * (even - GRADED / (2.0 * np.pi) * np.sin(2.0 * np.pi * even))
        elif kind == "flank":
            first = _lengths(sheets[f"{side} fillet"])[1][-1] / cells.fillet
            at = length[-1] * _growing(first / length[-1], number)
        else:
            at = np.interp(stations(form_of(sheet, STRETCHED_FOR), number, 1, 1.0)[0], s, length)
        at = np.interp(np.linspace(0.0, number, 2 * number + 1), np.arange(number + 1), at)
        grids[name] = grid_of(sheet, np.interp(at, length, s), z)
    return grids


def _lengths(sheet: Sheet) -> tuple[FloatArray, FloatArray]:
    """Find stations s = 0 ... 1 of a profile and the lengths (mm) from its start there, at mid-face."""
    s = np.linspace(0.0, 1.0, FINE + 1)
    steps = np.linalg.norm(np.diff(grid_of(sheet, s, np.zeros(1)).points[:, 0], axis=0), axis=1)
    return s, np.concatenate(([0.0], np.cumsum(steps)))


def _growing(first: float, number: int) -> FloatArray:
    """Find stations 0 ... 1 (number + 1,) whose steps grow from about `first` until they are even."""
    grown = GROWTH ** np.minimum(np.arange(number), 1000)  # which is more than any step needs
    steps = np.minimum(1.0, first * number * grown)
    return np.asarray(np.concatenate(([0.0], np.cumsum(steps))) / steps.sum())


def _corners(outline: dict[str, FloatArray]) -> dict[str, FloatArray]:
    return {name: curve[::2] for name, curve in outline.items()}


def _require_size(size: tuple[int, int], face: int, quadratic: bool, teeth: int) -> None:
    """Raise ValueError for a mesh of too many nodes; `size`: points and quadrilaterals of the section."""
    points, quads = size
    nodes = teeth * points * (face + 1)
    if quadratic:
        nodes += teeth * ((points + quads - 1) * (face + 1) + points * face)
    if nodes > MAX_NODES:
        text = f"the mesh takes about {nodes:.2g} nodes for {counted(teeth)}, the limit is {MAX_NODES:.2g}"
        raise ValueError(f"{text}: take a larger tolerance, fewer teeth or elements with 8 nodes")


@dataclass(frozen=True, eq=False)
class _Tooth:
    """One tooth: `points` (n, 3), `hexahedra` (m, 8 or 20), layer by layer, `first` and `last`: the
    nodes of its sides, `surfaces` as those of a VolumeMesh."""

    points: FloatArray
    hexahedra: Indices
    first: Indices
    last: Indices
    surfaces: dict[str, Indices]


def _layers(nodes: Indices, stride: int, count: int) -> Indices:
    """Find the node numbers of a section (..., k) in `count` layers (count * ..., k)."""
    return np.asarray((nodes + stride * np.arange(count)[:, None, None]).reshape(-1, nodes.shape[-1]))


def _edges(quads: Indices) -> tuple[Indices, Indices]:
    """Give the edges (e, 2) of quadrilaterals, and those (m, 4) of each, from each corner to the next."""
    sides = np.sort(np.stack((quads, np.roll(quads, -1, axis=1)), axis=-1), axis=-1)
    edges, numbers = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
    return edges, numbers.reshape(-1, 4)


def _along(section: Section, edges: Indices) -> dict[str, Indices]:
    """Give the edges along the curves of the boundary."""
    size = len(section.points)
    keys = edges @ (size, 1)
    found = {}
    for name, nodes in section.boundary.items():
        pairs = np.sort(np.stack((nodes[:-1], nodes[1:]), axis=-1), axis=-1)
        found[name] = np.searchsorted(keys, pairs @ (size, 1))
    return found


def _surfaces(section: Section, layers: int) -> dict[str, Indices]:
    """Find faces (k, 2) of each surface of one tooth."""
    edges, sides = _edges(section.quads)
    place = np.empty(len(edges), dtype=np.int64)
    place[sides.ravel()] = np.arange(sides.size)
    size = len(sides)
    faces: dict[str, list[Indices]] = {}
    for name, along in _along(section, edges).items():
        own = np.stack((place[along] // 4, 2 + place[along] % 4), axis=-1)
        stacked = (own + np.multiply.outer(size * np.arange(layers), (1, 0))[:, None]).reshape(-1, 2)
        faces.setdefault(surface_name(name), []).append(stacked)
    ends = np.arange(size)
    faces["toe"] = [np.stack((ends, 0 * ends), axis=-1)]
    faces["heel"] = [np.stack((ends + size * (layers - 1), 0 * ends + 1), axis=-1)]
    return {name: np.concatenate(parts) for name, parts in faces.items()}


def _linear(section: Section) -> _Tooth:
    """Make hexahedra with 8 nodes between every other station."""
    size, layers = len(section.points), section.points.shape[1] // 2
    hexahedra = _layers(np.concatenate((section.quads, section.quads + size), axis=1), size, layers)
    first, last = (_layers(section.boundary[name][None], size, layers + 1).ravel() for name in SIDES)
    points = section.points[:, ::2].swapaxes(0, 1).reshape(-1, 3)
    return _Tooth(points, hexahedra, first, last, _surfaces(section, layers))


def _quadratic(section: Section, outline: dict[str, FloatArray], bore: float) -> _Tooth:
    """Make hexahedra with 20 nodes between every other station."""
    quads, size = section.quads, len(section.points)
    (edges, sides), layers = _edges(quads), section.points.shape[1] // 2
    along = _along(section, edges)
    ends = section.points[:, ::2]
    middles = 0.5 * (ends[edges[:, 0]] + ends[edges[:, 1]])
    for name, curve in outline.items():
        middles[along[name], :, :2] = curve[1::2, ::2, :2]
    inner = middles[along["bore"], :, :2]
    middles[along["bore"], :, :2] = inner * (bore / np.linalg.norm(inner, axis=-1, keepdims=True))
    blocks = (ends, middles, section.points[:, 1::2])
    points = np.concatenate([block.swapaxes(0, 1).reshape(-1, 3) for block in blocks])
    starts = np.cumsum([0] + [block.shape[0] * block.shape[1] for block in blocks])
    corners = _layers(np.concatenate((quads, quads + size), axis=1), size, layers)
    flat = _layers(np.concatenate((sides, sides + len(edges)), axis=1), len(edges), layers) + starts[1]
    upright = _layers(quads, size, layers) + starts[2]

    def nodes_on(name: str) -> Indices:
        """Give the nodes of a side: of its sections, of their edges, and half-way between them."""
        nodes = section.boundary[name][None]
        parts = (
            _layers(nodes, size, layers + 1),
            _layers(along[name][None], len(edges), layers + 1) + starts[1],
            _layers(nodes, size, layers) + starts[2],
        )
        return np.concatenate([part.ravel() for part in parts])

    hexahedra = np.concatenate((corners, flat, upright), axis=1)
    first, last = (nodes_on(name) for name in SIDES)
    return _Tooth(points, hexahedra, first, last, _surfaces(section, layers))


def _joined(teeth: Sequence[_Tooth], count: int) -> VolumeMesh:
    """Join neighbouring teeth of a gear of `count`; all of them round the gear."""
    closed = len(teeth) == count
    numbers = joined_numbers([(len(one.points), one.first, one.last) for one in teeth], closed)
    size = teeth[0].hexahedra.shape[1]
    every = np.concatenate([own[one.hexahedra].ravel() for one, own in zip(teeth, numbers, strict=True)])
    used, hexahedra = np.unique(every, return_inverse=True)
    angles = 2.0 * np.pi / count * np.arange(len(teeth))
    points = np.concatenate(
        [turned(one.points, angle[None])[0] for one, angle in zip(teeth, angles, strict=True)]
    )
    bare = VolumeMesh(points[used], hexahedra.reshape(-1, size), {}, {}, {})
    surfaces = _named(teeth, closed)
    return VolumeMesh(
        bare.points,
        bare.hexahedra,
        surfaces,
        {name: np.unique(face_nodes(bare, faces)) for name, faces in surfaces.items()},
        {name: np.unique(faces[:, 0]) for name, faces in surfaces.items()},
    )


def _named(teeth: Sequence[_Tooth], closed: bool) -> dict[str, Indices]:
    """Give the surfaces of all teeth, and with several of them those of each."""
    starts = np.cumsum([0, *(len(one.hexahedra) for one in teeth)])
    surfaces = {}
    for name in NAMES:
        numbers = range(len(teeth))[teeth_with(name, len(teeth), closed)]
        each = [teeth[number].surfaces[name] + (starts[number], 0) for number in numbers]
        if each:
            surfaces[name] = np.concatenate(each)
        if len(teeth) > 1 and name not in SIDES:
            surfaces |= {f"{name} {number}": faces for number, faces in enumerate(each, 1)}
    return surfaces
