"""Structured hexahedra of one or more teeth with their part of the body.

The quadrilaterals of the transverse section (`section`) are the same at all stations along the face.
Between two stations they form a layer of hexahedra. Nodes of the outline are on the surfaces that the tool
cuts, nodes of the bore on its cylinder. Elements with 20 nodes have mid-side nodes on these surfaces, too. On
edges along the face, mid-side nodes are those of the section half-way between two stations. The other edges
of a section are straight, with mid-side nodes in their middle.

`element_sizes` has the numbers of elements and the nodes of the outline.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, Indices
from ..design.arguments import require_integers, require_member, require_numbers
from ..design.member import Member
from .element_sizes import Cells, boundary_nodes, cells_of, face_stations
from .hexahedral_mesh import VolumeMesh, element_shapes, face_nodes, rounded_down
from .section import SIDES, Section, section_of, section_size
from .solid import NAMES, joined_numbers, rotated_copies, teeth_with
from .tooth_body import bore_of, surface_name
from .tooth_boundary import counted, cut_sheets

ELEMENTS = {"C3D20": 20, "C3D20R": 20, "C3D8I": 8, "C3D8": 8}
"""Number of nodes of the elements, by the names of Abaqus."""


def tooth_hexahedra(
    member: Member,
    teeth: int | None = 1,
    element: str = "C3D20",
    tolerance: float | None = None,
    bore_radius: float | None = None,
    cells: Cells | Sequence[Cells] | None = None,
) -> VolumeMesh:
    """Return hexahedra of some teeth of a gear, in the frame of the gear.

    Parameters
    ----------
    member : Member
        A single member.
    teeth : int, optional
        Number of adjacent teeth, as in `gear_solid`; None for all teeth, the complete gear without sides.
    element : {'C3D20', 'C3D20R', 'C3D8I', 'C3D8'}
        Elements with 20 or 8 nodes. The reduced integration of C3D20R allows hourglass modes under a load on
        one face. C3D8I fails the patch test unless elements are parallelepipeds.
    tolerance : float, optional
        Largest distance of straight edges from the surfaces that the tool cuts, mm; see `cells_of`. By
        default 1/120 of the normal module, as for the command `mesh`.
    bore_radius : float, optional
        mm; 0.45 of the smallest root radius by default.
    cells : Cells or sequence of Cells, optional
        Numbers of elements, instead of `tolerance`. The numbers of different teeth may differ only in
        `flank`.

    Returns
    -------
    VolumeMesh

    Raises
    ------
    ValueError
        For a number of teeth that is not between 1 and that of the gear, more than 5 million nodes, distorted
        elements, cells that do not match those of the next tooth, and as `cut_sheets`,
        `bore_of` and `section_of`.

    References
    ----------
    Points: Eq. (6) of Ni et al. 2017; elements: beveloid_geom/shapes/README.md.

    Examples
    --------
    >>> from beveloid_geom import builtin_design, tooth_hexahedra
    >>> mesh = tooth_hexahedra(builtin_design().pinion, element="C3D8", tolerance=0.5)
    >>> mesh.hexahedra.shape[1], "right flank" in mesh.surfaces
    (8, True)
    """
    require_member(member)
    require_numbers(tolerance=tolerance, bore_radius=bore_radius)
    require_integers(teeth=teeth)
    if element not in ELEMENTS:
        raise ValueError(f"element must be one of {', '.join(ELEMENTS)}, got {element!r}")
    count = int(member.teeth)
    if teeth is not None and not 0 < teeth <= count:
        raise ValueError(f"teeth must be between 1 and {count}, got {teeth}")
    number = count if teeth is None else teeth
    if cells is None:
        module_per_tolerance = 120.0
        usual = float(member.tool.normal_module) / module_per_tolerance
        cells = cells_of(member, usual if tolerance is None else tolerance)
    each = [cells] * number if isinstance(cells, Cells) else list(cells)
    are_cells = all(isinstance(one, Cells) for one in each)
    if not are_cells or len(each) != number or len({replace(one, flank=1) for one in each}) > 1:
        limit = f"be given for {counted(number)} and may differ only in `flank`"
        raise ValueError(f"cells must {limit}, got {each}")
    bore, teeth_of = bore_of(member, bore_radius), {}
    for numbers in set(each):
        tooth = _tooth(member, numbers, ELEMENTS[element] == 20, bore, number)
        _require_shape(VolumeMesh(tooth.points, tooth.hexahedra, {}, {}, {}))
        teeth_of[numbers] = tooth
    return _joined([teeth_of[numbers] for numbers in each], count)


def _tooth(member: Member, cells: Cells, quadratic: bool, bore: float, teeth: int) -> _ToothHexahedra:
    """Return hexahedra of one tooth. Raises ValueError for numbers of cells below 1, and if `teeth` of them
    have too many nodes."""
    for name, number in vars(cells).items():
        if number < 1:
            raise ValueError(f"cells must be 1 or more, got {name}={number}")
    # The size is checked before the section is solved: first by the tooth alone, then with the body.
    _require_size((cells.tip * (cells.flank + cells.fillet),) * 2, cells.face, quadratic, teeth)
    sheets = cut_sheets(member)
    size = section_size(_corners(boundary_nodes(sheets, cells, np.zeros(1))), bore)
    _require_size(size, cells.face, quadratic, teeth)
    outline = boundary_nodes(sheets, cells, face_stations(sheets, cells.face))
    section = section_of(_corners(outline), bore)
    return _quadratic(section, outline, bore) if quadratic else _linear(section)


def _require_shape(mesh: VolumeMesh) -> None:
    """Raise ValueError for elements that are inverted or too distorted."""
    shape_cure = "reduce the tolerance, change the bore radius, or increase the tip radius of the tool"
    scaled, ratio = (float(values.min()) for values in element_shapes(mesh))
    # Smallest scaled Jacobian and smallest ratio of determinants, see `hexahedral_mesh.element_shapes`.
    min_shape = 0.2
    if not min(scaled, ratio) >= min_shape:
        text = (
            f"scaled Jacobian {rounded_down(scaled)}, ratio of determinants {rounded_down(ratio)}, "
            f"both must be at least {min_shape:g}"
        )
        raise ValueError(f"some elements are too distorted ({text}): {shape_cure}")


def _corners(outline: dict[str, FloatArray]) -> dict[str, FloatArray]:
    return {name: curve[::2] for name, curve in outline.items()}


def _require_size(size: tuple[int, int], face: int, quadratic: bool, teeth: int) -> None:
    """Raise ValueError for too many nodes; `size`: numbers of points and quadrilaterals of the section."""
    points, quads = size
    nodes = teeth * points * (face + 1)
    if quadratic:
        nodes += teeth * ((points + quads - 1) * (face + 1) + points * face)
    max_nodes = 5_000_000
    if nodes > max_nodes:
        text = f"the mesh needs about {nodes:.2g} nodes for {counted(teeth)}, the limit is {max_nodes:.2g}"
        cure = "increase the tolerance, or choose fewer teeth or elements with 8 nodes"
        raise ValueError(f"{text}: {cure}")


@dataclass(frozen=True, eq=False)
class _ToothHexahedra:
    """One tooth: `points` (n, 3), mm, `hexahedra` (m, 8 or 20) layer by layer, the nodes of its `first` and
    `last` side, and `surfaces` as in a VolumeMesh."""

    points: FloatArray
    hexahedra: Indices
    first: Indices
    last: Indices
    surfaces: dict[str, Indices]


def _layers(nodes: Indices, stride: int, count: int) -> Indices:
    """Return node numbers of a section (..., k), repeated for `count` layers: (count * ..., k)."""
    return np.asarray((nodes + stride * np.arange(count)[:, None, None]).reshape(-1, nodes.shape[-1]))


def _edges(quads: Indices) -> tuple[Indices, Indices]:
    """Return the edges (e, 2) of quadrilaterals, and the numbers (m, 4) of the edges of each quadrilateral,
    from each corner to the next."""
    sides = np.sort(np.stack((quads, np.roll(quads, -1, axis=1)), axis=-1), axis=-1)
    edges, numbers = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
    return edges, numbers.reshape(-1, 4)


def _along(section: Section, edges: Indices) -> dict[str, Indices]:
    """Return the numbers of the edges along each curve of the boundary."""
    size = len(section.points)
    keys = edges @ (size, 1)
    numbers = {}
    for name, nodes in section.boundary.items():
        pairs = np.sort(np.stack((nodes[:-1], nodes[1:]), axis=-1), axis=-1)
        numbers[name] = np.searchsorted(keys, pairs @ (size, 1))
    return numbers


def _surfaces(section: Section, layers: int) -> dict[str, Indices]:
    """Return the faces (k, 2) of each surface of one tooth: element and face number."""
    edges, sides = _edges(section.quads)
    place = np.empty(len(edges), dtype=np.int64)
    place[sides.ravel()] = np.arange(sides.size)
    size = len(sides)
    faces: dict[str, list[Indices]] = {}
    for name, along in _along(section, edges).items():
        first = np.stack((place[along] // 4, 2 + place[along] % 4), axis=-1)
        stacked = (first + np.multiply.outer(size * np.arange(layers), (1, 0))[:, None]).reshape(-1, 2)
        faces.setdefault(surface_name(name), []).append(stacked)
    ends = np.arange(size)
    faces["toe"] = [np.stack((ends, 0 * ends), axis=-1)]
    faces["heel"] = [np.stack((ends + size * (layers - 1), 0 * ends + 1), axis=-1)]
    return {name: np.concatenate(parts) for name, parts in faces.items()}


def _linear(section: Section) -> _ToothHexahedra:
    """Return hexahedra with 8 nodes; every second station has mid-side nodes and is not used."""
    size, layers = len(section.points), section.points.shape[1] // 2
    hexahedra = _layers(np.concatenate((section.quads, section.quads + size), axis=1), size, layers)
    first, last = (_layers(section.boundary[name][None], size, layers + 1).ravel() for name in SIDES)
    points = section.points[:, ::2].swapaxes(0, 1).reshape(-1, 3)
    return _ToothHexahedra(points, hexahedra, first, last, _surfaces(section, layers))


def _quadratic(section: Section, outline: dict[str, FloatArray], bore: float) -> _ToothHexahedra:
    """Return hexahedra with 20 nodes; every second station has mid-side nodes."""
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
        """Return the nodes of a side: corners, mid-side nodes in the sections, and between the sections."""
        nodes = section.boundary[name][None]
        parts = (
            _layers(nodes, size, layers + 1),
            _layers(along[name][None], len(edges), layers + 1) + starts[1],
            _layers(nodes, size, layers) + starts[2],
        )
        return np.concatenate([part.ravel() for part in parts])

    hexahedra = np.concatenate((corners, flat, upright), axis=1)
    first, last = (nodes_on(name) for name in SIDES)
    return _ToothHexahedra(points, hexahedra, first, last, _surfaces(section, layers))


def _joined(teeth: Sequence[_ToothHexahedra], count: int) -> VolumeMesh:
    """Return adjacent teeth of a gear with `count` teeth as one mesh."""
    closed = len(teeth) == count
    numbers = joined_numbers([(len(one.points), one.first, one.last) for one in teeth], closed)
    size = teeth[0].hexahedra.shape[1]
    every = np.concatenate([new[one.hexahedra].ravel() for one, new in zip(teeth, numbers, strict=True)])
    used, hexahedra = np.unique(every, return_inverse=True)
    angles = 2.0 * np.pi / count * np.arange(len(teeth))
    points = np.concatenate(
        [rotated_copies(one.points, angle[None])[0] for one, angle in zip(teeth, angles, strict=True)]
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


def _named(teeth: Sequence[_ToothHexahedra], closed: bool) -> dict[str, Indices]:
    """Return the surfaces of all teeth together and, if there are several teeth, also those of each tooth."""
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
