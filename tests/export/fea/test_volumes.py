"""Hexahedral meshes as files, read back by other libraries."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import pyvista as pv

from beveloid_geom.arrays import FloatArray, Indices
from beveloid_geom.export import VOLUME_FORMATS, identifier
from beveloid_geom.export.fea.abaqus import LoadCase, nearest_node, write_deck
from beveloid_geom.export.fea.load import ContactPlace, contact_load
from beveloid_geom.export.fea.volumes import disjoint_surfaces, write_volume
from beveloid_geom.shapes.hexahedral_mesh import (
    EDGES,
    VolumeMesh,
    face_nodes,
)

ELEMENTS = {"C3D20": 20, "C3D20R": 20, "C3D8I": 8, "C3D8": 8}
SIZE = np.array([30.0, 40.0, 20.0])
PLANES = {
    "right flank": (0, 1.0),
    "left flank": (0, 0.0),
    "tip": (1, 1.0),
    "bore": (1, 0.0),
    "first side": (2, 0.0),
    "last side": (2, 1.0),
}


def bent(points: FloatArray) -> FloatArray:
    """Return the points of a block with curved faces."""
    x, y, z = points.T
    return np.stack((x + 0.002 * y**2 + 0.01 * z, y + 0.05 * z, z + 0.02 * x), axis=-1)


def block(nodes: int, counts: tuple[int, int, int] = (3, 4, 2), shape: Any = bent) -> VolumeMesh:
    """Return a block of hexahedra whose six sides have the names of a tooth."""
    step = 2 if nodes == 20 else 1
    fine = step * np.array(counts)
    grid = np.stack(np.meshgrid(*(np.arange(n + 1) for n in fine), indexing="ij"), axis=-1).reshape(-1, 3)
    numbers = np.arange(len(grid)).reshape(fine + 1)
    corners = np.array(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    )
    offsets = [*(step * corners), *(corners[a] + corners[b] for a, b in EDGES)][:nodes]
    cells = step * np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1).reshape(-1, 3)
    hexahedra = np.stack([numbers[tuple((cells + offset).T)] for offset in offsets], axis=-1)
    used, hexahedra = np.unique(hexahedra, return_inverse=True)
    flat = grid[used] / fine
    hexahedra = hexahedra.reshape(-1, nodes)
    every = np.stack(np.meshgrid(np.arange(len(hexahedra)), np.arange(6), indexing="ij"), -1).reshape(-1, 2)
    bare = VolumeMesh(shape(flat * SIZE), hexahedra, {}, {}, {})
    on = flat[face_nodes(bare, every)]
    surfaces = {
        name: every[np.all(np.abs(on[..., axis] - place) < 1e-12, axis=1)]
        for name, (axis, place) in PLANES.items()
    }
    node_sets = {name: np.unique(face_nodes(bare, faces)) for name, faces in surfaces.items()}
    element_sets = {name: np.unique(faces[:, 0]) for name, faces in surfaces.items()}
    return VolumeMesh(bare.points, hexahedra, surfaces, node_sets, element_sets)


def place_at(
    y: float, z: float, curvature: tuple[float, float] = (0.002, 0.04), turn: float = 0.4
) -> ContactPlace:
    """Return a contact on the right flank of the bent block, with its long axis at an angle `turn` from z."""
    x, normal = np.array([30.0, y, z]), np.cross((0.004 * y, 1.0, 0.0), (0.01, 0.05, 1.0))
    normal = normal / np.linalg.norm(normal)
    first = np.cross(normal, (0.0, np.cos(turn), np.sin(turn)))
    first = first / np.linalg.norm(first)
    return ContactPlace(
        bent(x[None])[0], normal, np.array(curvature), np.stack((first, np.cross(normal, first)))
    )


def case_of(mesh: VolumeMesh) -> LoadCase:
    load = contact_load(mesh, "right flank", place_at(23.0, 11.0), 950.0)
    return LoadCase(load, nearest_node(mesh, np.array([0.0, 40.0, 10.0])), fixed=("bore",))


def written(mesh: VolumeMesh, folder: Path, suffix: str, element: str) -> Path:
    path = folder / f"tooth{suffix}"
    write_volume(mesh, path, element, case=case_of(mesh), comment=["Pair Ä,\n1, pinion"])
    return path


# Faces and loads


@pytest.mark.parametrize("nodes", [8, 20])
def test_faces_are_clockwise_seen_from_outside(nodes: int) -> None:
    mesh = block(nodes, shape=lambda points: points)
    assert sum(len(faces) for faces in mesh.surfaces.values()) == 2 * (3 * 4 + 4 * 2 + 2 * 3)
    for name, (axis, place) in PLANES.items():
        corners = mesh.points[face_nodes(mesh, mesh.surfaces[name])]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1])
        assert np.all(across[:, axis] * (1.0 if place else -1.0) < 0.0)
        if nodes == 20:
            ahead = np.roll(corners[:, :4], -1, axis=1)
            np.testing.assert_allclose(corners[:, 4:], 0.5 * (corners[:, :4] + ahead), rtol=0, atol=1e-12)


# Files


@pytest.mark.parametrize("suffix", VOLUME_FORMATS)
@pytest.mark.parametrize("element", ELEMENTS)
def test_meshio_reads_the_same_mesh(tmp_path: Path, suffix: str, element: str) -> None:
    mesh = block(ELEMENTS[element])
    read = meshio.read(written(mesh, tmp_path, suffix, element))
    precision = {".inp": 5e-11, ".bdf": 6e-11}.get(suffix, 0.0)
    name = {8: "hexahedron", 20: "hexahedron20"}[ELEMENTS[element]]
    hexahedra = np.concatenate([cells.data for cells in read.cells if cells.type == name])
    assert len(read.points) == len(mesh.points)
    assert hexahedra.shape == mesh.hexahedra.shape
    if suffix != ".msh":  # Gmsh's format lists nodes by what owns them
        np.testing.assert_array_equal(hexahedra, mesh.hexahedra)
    np.testing.assert_allclose(read.points[hexahedra], mesh.points[mesh.hexahedra], rtol=0, atol=precision)


@pytest.mark.parametrize("element", ["C3D8", "C3D20"])
def test_vtu_in_vtk(tmp_path: Path, element: str) -> None:
    mesh = block(ELEMENTS[element])
    read = pv.read(written(mesh, tmp_path, ".vtu", element))
    np.testing.assert_array_equal(read.points, mesh.points)
    assert read.n_cells == len(mesh.hexahedra)
    flat = block(ELEMENTS[element], shape=lambda points: points)
    assert pv.read(written(flat, tmp_path, ".vtu", element)).volume == pytest.approx(np.prod(SIZE))
    for name in PLANES:
        nodes, elements = (data[identifier(name)] for data in (read.point_data, read.cell_data))
        np.testing.assert_array_equal(np.flatnonzero(nodes), mesh.node_sets[name])
        np.testing.assert_array_equal(np.flatnonzero(elements), mesh.element_sets[name])


@pytest.mark.parametrize("element", ["C3D8I", "C3D20"])
def test_inp_holds_the_sets(tmp_path: Path, element: str) -> None:
    mesh = block(ELEMENTS[element])
    path = written(mesh, tmp_path, ".inp", element)
    read = meshio.read(path)
    for name in PLANES:
        np.testing.assert_array_equal(read.point_sets[identifier(name)], mesh.node_sets[name])
        np.testing.assert_array_equal(read.cell_sets[identifier(name)][0], mesh.element_sets[name])
    np.testing.assert_array_equal(read.point_sets["fixed"], mesh.node_sets["bore"])
    np.testing.assert_array_equal(read.point_sets["loaded"], np.sort(case_of(mesh).load.nodes))
    assert surfaces_in(path) == {identifier(name): mesh.surfaces[name].tolist() for name in PLANES}


def surfaces_in(path: Path) -> dict[str, list[list[int]]]:
    """Return element index and face number of each *SURFACE."""
    found: dict[str, list[list[int]]] = {}
    name = ""
    for line in path.read_text().splitlines():
        if line.startswith("*"):
            match = re.fullmatch(r"\*SURFACE, NAME=(\w+), TYPE=ELEMENT", line)
            name = match[1] if match else ""
        elif name:
            element, face = line.split(", S")
            found.setdefault(name, []).append([int(element) - 1, int(face) - 1])
    return found


def test_inp_has_valid_lines(tmp_path: Path) -> None:
    """Numbers in sets are unique, coordinates have 12 digits, lines have at most 16 entries; units and frame
    are stated."""
    path = written(block(20), tmp_path, ".inp", "C3D20")
    text = path.read_text(encoding="ascii")
    assert "Units: N, mm, MPa, tonne" in text
    assert "Own frame of the gear" in text
    for block_text in re.findall(r"^\*(?:NSET|ELSET).*\n((?:[^*].*\n)+)", text, re.MULTILINE):
        numbers = block_text.replace("\n", " ").replace(",", " ").split()
        assert len(numbers) == len(set(numbers))
    for line in text.splitlines():
        if not line.startswith("*"):
            assert line.rstrip(",").count(",") < 16
            for number in re.findall(r"-?\d+\.\d+", line):
                assert len(number.replace("-", "").replace(".", "").lstrip("0")) <= 12
        assert len(line) <= 130


BARE = "HEADING, NODE, ELASTIC, DENSITY, STEP, STATIC, BOUNDARY, CLOAD, NODE FILE, EL FILE, END STEP"
BOTH_READ: dict[str, set[str]] = {
    **{keyword: set() for keyword in BARE.split(", ")},
    "ELEMENT": {"TYPE", "ELSET"},
    "NSET": {"NSET"},
    "ELSET": {"ELSET"},
    "SURFACE": {"NAME", "TYPE=ELEMENT"},
    "MATERIAL": {"NAME"},
    "SOLID SECTION": {"ELSET", "MATERIAL"},
    "NODE PRINT": {"NSET", "TOTALS=YES"},
}
"""Keywords and parameters that both the Keywords Reference Guide of Abaqus and the manual of CalculiX 2.20
have.

The value is given if the two programs have different values."""


def test_inp_has_only_keywords_of_both_programs(tmp_path: Path) -> None:
    text = written(block(20), tmp_path, ".inp", "C3D20").read_text(encoding="ascii")
    used = re.findall(r"^\*([A-Z].*)$", text, re.MULTILINE)
    assert len(used) > 20
    for line in used:
        keyword, *parameters = line.split(", ")
        for parameter in parameters:
            assert parameter.partition("=")[0] in BOTH_READ[keyword] or parameter in BOTH_READ[keyword], line


def test_the_load_is_described(tmp_path: Path) -> None:
    mesh = block(20)
    text = written(mesh, tmp_path, ".inp", "C3D20").read_text(encoding="ascii")
    assert f"** {case_of(mesh).load.description},\n" in text
    assert "Stresses at the contact are not resolved." in text


def test_duplicates_in_sets_are_written_once(tmp_path: Path) -> None:
    mesh = block(8)
    twice: dict[str, Indices] = {"tip": np.array([5, 3, 3, 5, 1])}
    doubled = VolumeMesh(mesh.points, mesh.hexahedra, {}, twice, twice)
    write_deck(tmp_path / "a.inp", doubled, "C3D8")
    read = meshio.read(tmp_path / "a.inp")
    assert read.point_sets["tip"].tolist() == read.cell_sets["tip"][0].tolist() == [1, 3, 5]


def physical_names(path: Path) -> dict[str, int]:
    """Return names and tags of the physical groups."""
    return {name: int(tag) for name, (tag, _) in meshio.read(path).field_data.items()}


@pytest.mark.parametrize("element", ["C3D8", "C3D20"])
@pytest.mark.parametrize("counts", [(3, 4, 2), (1, 1, 1)])
def test_msh_holds_the_surfaces_as_physical_groups(
    tmp_path: Path, element: str, counts: tuple[int, int, int]
) -> None:
    """Surfaces are physical groups, also for a single element, where every node is on three surfaces."""
    mesh, path = block(ELEMENTS[element], counts), tmp_path / "a.msh"
    write_volume(mesh, path, element)
    read, tags = meshio.read(path), physical_names(path)
    assert set(tags) == {*map(identifier, PLANES), "body"}
    for name in PLANES:
        blocks = [
            cells.data
            for cells, groups in zip(read.cells, read.cell_data["gmsh:physical"], strict=True)
            if groups[0] == tags[identifier(name)]
        ]
        corners = mesh.points[face_nodes(mesh, mesh.surfaces[name])]
        np.testing.assert_array_equal(read.points[np.concatenate(blocks)], corners)


def test_msh_of_more_surfaces_than_nodes_is_refused(tmp_path: Path) -> None:
    mesh = block(8, (1, 1, 1))
    surfaces = {f"side {letter}": mesh.surfaces["tip"] for letter in "abcde"}
    crowded = VolumeMesh(mesh.points, mesh.hexahedra, surfaces, {}, {})
    with pytest.raises(ValueError, match="the mesh is too coarse"):
        write_volume(crowded, tmp_path / "a.msh", "C3D8")


def test_surfaces_of_each_tooth_replace_their_union() -> None:
    mesh = block(8)
    first, last = mesh.surfaces["tip"][:2], mesh.surfaces["tip"][2:]
    surfaces = {**mesh.surfaces, "tip 1": first, "tip 2": last, "heel": first[:0]}
    names = disjoint_surfaces(VolumeMesh(mesh.points, mesh.hexahedra, surfaces, {}, {}))
    assert set(names) == {*PLANES, "tip 1", "tip 2"} - {"tip"}


def test_bdf_holds_the_sets(tmp_path: Path) -> None:
    mesh = block(20)
    text = written(mesh, tmp_path, ".bdf", "C3D20").read_text(encoding="ascii")
    control, bulk = text.split("BEGIN BULK\n")
    for name, nodes in mesh.node_sets.items():
        match = re.search(
            rf'^SET (\d+) = ([\d,\n]+)\n\$HMSET +\1 +1 "{identifier(name)}"$', control, re.MULTILINE
        )
        assert match is not None
        assert [int(number) - 1 for number in match[2].replace("\n", "").split(",")] == nodes.tolist()
    assert all(len(line) <= 72 for line in control.splitlines())
    lines = [line[2:] for line in control.partition("SOL")[0].splitlines()]
    assert "from mid-face, x through the first tooth." in " ".join(lines)
    assert all(len(line) <= 80 for line in bulk.splitlines())


@pytest.mark.parametrize(("scale", "precision"), [(-1e3, 6e-10), (1e3, 6e-11), (-1e6, 6e-7)])
def test_bdf_uses_all_characters_of_its_fields(tmp_path: Path, scale: float, precision: float) -> None:
    """Coordinates up to 40 m and 40 km have as many decimals as 16 characters can hold."""
    mesh = block(8, shape=lambda points: scale * points + np.sign(scale) / 3.0)
    write_volume(mesh, tmp_path / "a.bdf", "C3D8")
    np.testing.assert_allclose(meshio.read(tmp_path / "a.bdf").points, mesh.points, rtol=0, atol=precision)


@pytest.mark.parametrize(("nodes", "element"), [(8, "C3D20"), (20, "C3D8"), (8, "C3D10")])
def test_other_numbers_of_nodes_are_rejected(tmp_path: Path, nodes: int, element: str) -> None:
    with pytest.raises(ValueError, match="cannot be written as"):
        write_deck(tmp_path / "a.inp", block(nodes), element)
