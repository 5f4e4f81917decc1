"""`beveloid_geom.write`: every kind of geometry by the suffix of the path."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import meshio
import pytest
import pyvista as pv
import trimesh

import beveloid_geom as bg
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export import SURFACE_FORMATS, VOLUME_FORMATS
from beveloid_geom.export.parts import gear_surface
from beveloid_geom.export.scene import pair_scene
from beveloid_geom.shapes.surface_mesh import gear_mesh
from tests.oracle.table1 import table1

DESIGN = table1()
SURFACES: dict[str, Callable[[], Any]] = {
    "solid": lambda: bg.gear_solid(DESIGN.pinion, 0.2, 1),
    "flank": lambda: bg.sample_flank(DESIGN.pinion, "right", 0.05),
    "gear mesh": lambda: gear_mesh(DESIGN.pinion, 0.2, range(1)),
    "surface": lambda: gear_surface(DESIGN.pinion, ".vtu", 0.2, 1),
}


@cache
def made(name: str) -> Any:
    return SURFACES[name]()


@pytest.mark.parametrize("kind", [str, Path])
@pytest.mark.parametrize("suffix", SURFACE_FORMATS)
@pytest.mark.parametrize("name", SURFACES)
def test_surfaces(tmp_path: Path, name: str, suffix: str, kind: type) -> None:
    path = tmp_path / f"a{suffix}"
    bg.write(made(name), kind(path))
    faces = made(name).faces if name != "flank" else None
    count = len(trimesh.load_mesh(path, process=False).faces) if suffix == ".3mf" else pv.read(path).n_cells
    assert count == len(faces) if faces is not None else count > 10
    if suffix == ".vtp" and name != "solid":
        assert "normals" in pv.read(path).point_data
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("suffix", VOLUME_FORMATS)
@pytest.mark.parametrize("element", ["C3D20", "C3D8"])
def test_hexahedra(tmp_path: Path, suffix: str, element: str) -> None:
    mesh = bg.tooth_hexahedra(DESIGN.pinion, element=element, tolerance=0.3)
    bg.write(mesh, str(tmp_path / f"a{suffix}"))
    cells = meshio.read(tmp_path / f"a{suffix}").cells
    assert sum(len(block.data) for block in cells if "hexa" in block.type) == len(mesh.hexahedra)


def test_scenes(tmp_path: Path) -> None:
    position = meshing_pair(DESIGN)
    items = pair_scene(DESIGN, position, position.frames, 0.3)
    bg.write(items, tmp_path / "a.glb")
    scene: Any = trimesh.load(tmp_path / "a.glb")
    assert set(scene.geometry) == {item.name for item in items}


def test_members(tmp_path: Path) -> None:
    pytest.importorskip("OCP", exc_type=ImportError)
    bg.write(DESIGN.gear, tmp_path / "a.step")
    assert "right flank 45" in (tmp_path / "a.step").read_text(encoding="ascii")


@pytest.mark.parametrize(
    ("value", "name", "error", "text"),
    [
        (3.0, "a.stl", TypeError, "cannot write a float: pass a solid, a flank grid"),
        ([], "a.glb", TypeError, "cannot write a list"),
        ("solid", "a.inp", ValueError, r"'\.inp' does not suit this object: give one of \.stl"),
        ("solid", "a.step", ValueError, r"'\.step' does not suit .* \.vtu, or pass the member$"),
        (
            DESIGN.pinion,
            "a.stl",
            ValueError,
            r"'\.stl' does not suit .* \.stp, or pass gear_solid\(member\)$",
        ),
        ("solid", "a", ValueError, "'' is not a known format"),
        ("solid", "none/a.stl", FileNotFoundError, "No such folder: .*none"),
    ],
)
def test_invalid_objects_and_paths(
    tmp_path: Path, value: Any, name: str, error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=text):
        bg.write(made(value) if isinstance(value, str) else value, tmp_path / name)
    assert not os.listdir(tmp_path)


def test_a_failure_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    (tmp_path / "a.stl").write_text("old")
    monkeypatch.setattr("beveloid_geom.export.surfaces.write_stl", full)
    with pytest.raises(OSError, match="No space left"):
        bg.write(made("solid"), tmp_path / "a.stl")
    assert (tmp_path / "a.stl").read_text() == "old"
    assert os.listdir(tmp_path) == ["a.stl"]
