"""Surfaces as files, read back by a different library than the one that wrote them."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import pyvista as pv
import trimesh
from numpy.typing import NDArray

from beveloid_geom import Errors, contact_pattern, path_of_contact, sample_flank
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export import FIELD_FORMATS, SURFACE_FORMATS, parts
from beveloid_geom.export.surfaces import SurfaceMesh, in_fixed, joined_surfaces, write_surface
from beveloid_geom.gear.flank import flank_patch
from beveloid_geom.pair.frames import normals_to_fixed, to_fixed
from beveloid_geom.shapes.sampling import FlankGrid
from tests.oracle.table1 import table1

TOLERANCE = 0.02
PRECISION = {".stl": 4e-6, ".ply": 0.0, ".obj": 6e-10}
"""mm, on the pinion: half the last place of single precision, or of nine decimals."""
PARTS = ("right flank", "left flank", "right fillet", "left fillet", "tip", "bottom", "toe", "heel", "bore")


@lru_cache(maxsize=1)
def flank_surface() -> SurfaceMesh:
    """Return a flank with a scalar, a vector and a field on its triangles."""
    surface = parts.flank_part(table1(), 0, "right", TOLERANCE, None, ())
    fields = {**surface.point_fields, "x_mm": surface.points[:, 0]}
    return replace(surface, point_fields=fields, cell_fields={"number": np.arange(len(surface.faces))})


def triangles(path: Path) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return points and faces read by meshio, by VTK for .vtp and by trimesh for .3mf."""
    if path.suffix == ".vtp":
        mesh = pv.read(path)
        return np.asarray(mesh.points), mesh.regular_faces
    if path.suffix == ".3mf":
        solid = trimesh.load_mesh(path, process=False)
        return np.asarray(solid.vertices), np.asarray(solid.faces)
    read = meshio.read(path)
    return read.points, read.cells_dict["triangle"]


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj"])
def test_meshio_reads_surfaces(tmp_path: Path, suffix: str) -> None:
    path, surface = tmp_path / f"flank{suffix}", flank_surface()
    write_surface(surface, path)
    points, faces = triangles(path)
    assert len(faces) == len(surface.faces)
    np.testing.assert_allclose(points[faces], surface.points[surface.faces], rtol=0, atol=PRECISION[suffix])
    if suffix != ".stl":
        np.testing.assert_array_equal(faces, surface.faces)
        data = meshio.read(path).point_data
        read = data["obj:vn"] if suffix == ".obj" else np.stack([data[f"n{axis}"] for axis in "xyz"], -1)
        np.testing.assert_allclose(read, surface.point_fields["normals"], rtol=0, atol=1e-7)


@pytest.mark.parametrize("suffix", FIELD_FORMATS)
def test_vtk_reads_the_fields(tmp_path: Path, suffix: str) -> None:
    """VTK reads the exact coordinates and fields."""
    surface, path = flank_surface(), tmp_path / f"flank{suffix}"
    write_surface(surface, path)
    read = pv.read(path)
    np.testing.assert_array_equal(read.points, surface.points)
    faces = read.regular_faces if suffix == ".vtp" else read.cells_dict[pv.CellType.TRIANGLE]
    np.testing.assert_array_equal(faces, surface.faces)
    assert set(read.point_data) == set(surface.point_fields)
    assert set(read.cell_data) == {"number"}
    for name, values in surface.point_fields.items():
        np.testing.assert_array_equal(read.point_data[name], np.squeeze(values))
    np.testing.assert_array_equal(read.cell_data["number"], np.arange(len(surface.faces)))


@pytest.mark.parametrize("suffix", FIELD_FORMATS)
def test_parts_are_named_in_vtk_files(tmp_path: Path, suffix: str) -> None:
    """The field data have an array for each part: its number in the cell field 'part'."""
    write_surface(tooth(suffix), tmp_path / f"a{suffix}")
    numbers = pv.read(tmp_path / f"a{suffix}").field_data
    for number, name in enumerate(PARTS):
        assert numbers[name.replace(" ", "_")].tolist() == [number]


def test_vtp_with_normals_and_without_fields(tmp_path: Path) -> None:
    write_surface(flank_surface(), tmp_path / "a.vtp")
    assert pv.read(tmp_path / "a.vtp").point_data.active_normals_name == "normals"
    bare = SurfaceMesh(flank_surface().points, flank_surface().faces, {}, {})
    write_surface(bare, tmp_path / "b.vtp")
    assert pv.read(tmp_path / "b.vtp").n_cells == len(bare.faces)


@lru_cache(maxsize=6)
def tooth(suffix: str) -> SurfaceMesh:
    return parts.gear_surface(table1().pinion, suffix, 0.05, 2)


@pytest.mark.parametrize("suffix", SURFACE_FORMATS)
def test_every_format_holds_the_same_tooth(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"tooth{suffix}"
    write_surface(tooth(suffix), path)
    points, faces = triangles(path)
    one = trimesh.Trimesh(points, faces, process=False)
    closed = tooth(".stl")
    reference = trimesh.Trimesh(closed.points, closed.faces, process=False)
    assert len(points) == len(tooth(suffix).points) or suffix == ".stl"
    assert len(faces) == len(closed.faces)
    assert one.volume == pytest.approx(reference.volume, rel=1e-7)
    assert one.area == pytest.approx(reference.area, rel=1e-7)
    assert one.is_watertight == (suffix in (".stl", ".ply", ".obj", ".3mf"))  # files without fields


def test_parts_are_numbered() -> None:
    mesh = tooth(".vtp")
    normals = mesh.point_fields["normals"][mesh.faces[mesh.cell_fields["part"] == 6]]
    np.testing.assert_array_equal(normals, np.broadcast_to((0.0, 0.0, -1.0), normals.shape))  # the toe


def test_a_pair_has_groups_and_names(tmp_path: Path) -> None:
    """VTK's reader numbers the groups. The fields 'pinion' and 'gear' name the members."""
    design = table1()
    pose = meshing_pair(design)
    plain = parts.pair_surface(design, pose.frames, ".obj", 0.1)
    write_surface(plain, tmp_path / "a.obj", title="pair")
    text = (tmp_path / "a.obj").read_text()
    assert re.findall(r"^g (\w+)$", text, re.MULTILINE) == ["pinion", "gear"]
    np.testing.assert_array_equal(pv.read(tmp_path / "a.obj")["GroupIds"], plain.cell_fields["member"])
    points, faces = meshio.read(tmp_path / "a.obj").points, meshio.read(tmp_path / "a.obj").cells
    np.testing.assert_allclose(points, plain.points, rtol=0, atol=6e-10)
    np.testing.assert_array_equal(np.concatenate([cells.data for cells in faces]), plain.faces)
    write_surface(plain, tmp_path / "a.3mf", title="pair")
    scene: Any = trimesh.load(tmp_path / "a.3mf", process=False)
    assert (scene.units, [*scene.geometry]) == ("millimeter", ["pinion", "gear"])
    points = np.concatenate([mesh.vertices for mesh in scene.geometry.values()])
    np.testing.assert_allclose(points, plain.points, rtol=0, atol=1e-12)
    fields = parts.pair_surface(design, pose.frames, ".vtu", 0.1)
    for suffix in FIELD_FORMATS:
        write_surface(fields, tmp_path / f"a{suffix}")
        data = pv.read(tmp_path / f"a{suffix}").cell_data
        for number, name in enumerate(("pinion", "gear")):
            np.testing.assert_array_equal(data[name], np.asarray(data["member"]) == number)


def test_stl_has_a_title(tmp_path: Path) -> None:
    write_surface(tooth(".stl"), tmp_path / "a.stl", title="solid pinion-tooth of Zähne.toml, mm" + 60 * ".")
    data = (tmp_path / "a.stl").read_bytes()
    assert data.startswith(b"beveloid-geom solid pinion-tooth of Z?hne.toml, mm....")
    assert len(data) == 84 + 50 * len(tooth(".stl").faces)
    assert int.from_bytes(data[80:84], "little") == len(tooth(".stl").faces)


@pytest.mark.parametrize("suffix", SURFACE_FORMATS)
def test_files_are_reproducible_and_titles_are_one_line(tmp_path: Path, suffix: str) -> None:
    for name in ("a", "b"):
        write_surface(tooth(suffix), tmp_path / f"{name}{suffix}", title="pinion of\nmy\r\ndesign")
    first, second = ((tmp_path / f"{name}{suffix}").read_bytes() for name in ("a", "b"))
    assert first == second
    if suffix == ".obj":
        assert first.startswith(b"# beveloid-geom pinion of my design\n")


# Positions in S_f

LAYOUTS = {
    "as mounted": Errors(),
    "in error": Errors(offset=0.1, shaft_angle=1e-5, pinion_axial=0.3, gear_axial=-0.2),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_pose_puts_both_flanks_at_the_contact(flank: str, name: str) -> None:
    design = table1((0.001, -0.001), LAYOUTS[name])
    pose, path = meshing_pair(design, flank), path_of_contact(design, flank, 5)
    np.testing.assert_allclose(pose.contact, path.point[2], rtol=0, atol=1e-9)
    normals = []
    for member in (0, 1):
        frame = pose.frames[member]
        l, u = ((path.l1, path.u1), (path.l2, path.u2))[member]
        patch = flank_patch(design.members[member], flank, l[2], u[2])
        np.testing.assert_allclose(patch.point, pose.point[member], rtol=0, atol=1e-9)
        np.testing.assert_allclose(to_fixed(frame, pose.point[member]), pose.contact, rtol=0, atol=1e-9)
        normals.append(normals_to_fixed(frame, pose.normal[member]))
    np.testing.assert_allclose(normals[0], -normals[1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(normals[0], path.normal[2], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("offset", "message"),
    [(6.0, "right flanks have no path of contact"), (np.zeros(3), "design must be a single design")],
)
def test_a_position_without_contact_is_rejected(offset: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        meshing_pair(table1((0.0, 0.0), Errors(offset=offset)))


@pytest.mark.parametrize("suffix", [".stl", ".vtu"])
def test_pair_touches_at_the_contact(tmp_path: Path, suffix: str) -> None:
    """The triangles of both gears are within the tolerance of the contact point."""
    design, path = table1(), tmp_path / f"pair{suffix}"
    pose = meshing_pair(design)
    surface = parts.pair_surface(design, pose.frames, suffix, TOLERANCE)
    write_surface(surface, path)
    points, faces = triangles(path)
    split = surface.cell_fields["member"]
    assert set(np.unique(split)) == {0, 1}
    for member in (0, 1):
        gear = pv.PolyData.from_regular_faces(points, faces[split == member])
        _, closest = gear.find_closest_cell(pose.contact, return_closest_point=True)
        assert np.linalg.norm(closest - pose.contact) < TOLERANCE
        axis, foot = pose.frames[member][0][:, 2], pose.frames[member][1]
        own = (gear.points[np.unique(faces[split == member])] - foot) @ axis
        half = 0.5 * float(design.members[member].face_width)
        assert (own.min(), own.max()) == pytest.approx((-half, half), abs=1e-4)


def test_moving_a_surface_turns_its_normals() -> None:
    pose, surface = meshing_pair(table1()), flank_surface()
    moved = in_fixed(surface, pose.frames[1])
    back = np.linalg.inv(pose.frames[1][0])
    normals = moved.point_fields["normals"] @ back.T
    np.testing.assert_allclose(normals, surface.point_fields["normals"], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(moved.point_fields["x_mm"], surface.point_fields["x_mm"])
    two = joined_surfaces([surface, SurfaceMesh(moved.points, moved.faces, {"normals": moved.points}, {})])
    assert set(two.point_fields) == {"normals"}
    assert not two.cell_fields
    np.testing.assert_array_equal(two.points[two.faces[len(surface.faces) :]], moved.points[moved.faces])


# Fields on flanks


@pytest.mark.parametrize("member", [0, 1])
def test_separation_is_least_at_the_contact(flank: str, member: int) -> None:
    design = table1((0.001, -0.001))
    pose, path = meshing_pair(design, flank), path_of_contact(design, flank, 3)
    l, z = ((path.l1, path.pinion_z), (path.l2, path.gear_z))[member]
    nothing = np.zeros((1, 1, 3))
    at_contact = FlankGrid(nothing, nothing, l[1:2, None], z[1:2], 0.0)
    assert parts.separation_field(design, pose, member, at_contact) == pytest.approx(0.0, abs=1e-9)
    grid = sample_flank(design.members[member], flank, 1e-3)
    field = parts.separation_field(design, pose, member, grid)
    known = field[np.isfinite(field)]
    assert 0.6 * field.size < known.size < field.size  # a part of the flank has no mating flank opposite
    assert known.min() > -1e-9


def test_separation_is_the_distance_to_the_mating_gear() -> None:
    """The distance from the triangles of the mating gear shares no code with the calculation."""
    design = table1((0.001, -0.001))
    pose, tolerance = meshing_pair(design), 2e-3
    grid = sample_flank(design.pinion, "right", 1e-4)
    field = parts.separation_field(design, pose, 0, grid)
    gear = in_fixed(parts.gear_surface(design.gear, ".stl", tolerance, 1), pose.frames[1])
    mesh = pv.PolyData.from_regular_faces(gear.points, gear.faces.astype(int))
    points = to_fixed(pose.frames[0], grid.points)
    inside = np.isfinite(field) & (np.abs(grid.z) < 15.0) & (field < 0.05)
    _, closest = mesh.find_closest_cell(points[inside], return_closest_point=True)
    distance = np.linalg.norm(closest - points[inside], axis=-1)
    assert inside.sum() > 100
    np.testing.assert_allclose(field[inside], distance, rtol=0, atol=1.5 * tolerance)


def test_pattern_field_is_that_of_the_contact_pattern() -> None:
    design = table1((0.001, -0.001))
    pose, exact = meshing_pair(design), contact_pattern(design, "right", resolution=8.0).gear
    same = FlankGrid(exact.points, exact.points, exact.l, exact.z[0], 0.0)
    field = parts.pattern_field(design, pose, 1, same)
    np.testing.assert_allclose(field, exact.least, rtol=0, atol=1e-9)


def test_pattern_and_separation_in_one_file(tmp_path: Path) -> None:
    """A file can have both fields. Without transmission error, the smallest separation does not exceed that
    in the middle of the path."""
    design = table1()
    pose = meshing_pair(design, "left")
    surface = parts.flank_part(design, 0, "left", 1e-3, pose, ["pattern", "separation"])
    write_surface(surface, tmp_path / "a.vtu")
    data = pv.read(tmp_path / "a.vtu").point_data
    least, middle = (np.asarray(data[name]) for name in ("pattern", "separation"))
    assert -1e-9 < np.nanmin(least) < MARKING_SEPARATION_MM < np.nanmax(least)
    near = middle < 0.02
    assert near.sum() > 10
    assert (least - middle)[near].max() < 2e-5


def test_estimate_of_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of points is inversely proportional to the tolerance, within a third."""
    pinion = table1().pinion
    counted: list[float] = []

    def count(tolerance: float) -> int:
        counted.append(tolerance)
        return int(sample_flank(pinion, "right", tolerance).l.size)

    monkeypatch.setattr(parts, "memory_limit", lambda: 0)
    fine = 2e-5
    with pytest.raises(ValueError, match="needs about") as refusal:
        parts.require_surface_memory(count, fine)
    assert counted == [parts.COUNTING_TOLERANCE_MM]
    match: Any = re.search(r"about ([\d.e+]+) points", str(refusal.value))
    assert float(match[1]) == pytest.approx(count(fine), rel=0.3)
    parts.require_surface_memory(count, parts.COUNTING_TOLERANCE_MM)  # coarse ones are not counted
