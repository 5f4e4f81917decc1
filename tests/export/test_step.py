"""STEP files, read back by the kernel: one valid solid, exact volume, flanks and fillets."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass, replace
from math import pi, radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beveloid_geom import FlankDeviations, Member, Modification, measuring_grid
from beveloid_geom.arrays import FloatArray, flank_sign
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export.step import write_step, write_step_pair
from beveloid_geom.shapes.tooth_body import bore_of
from tests.export.gmsh_model import opened_in_gmsh
from tests.oracle.table1 import table1
from tests.oracle.tooth_volume import Exact, exact_places, exact_volume

PINION, GEAR = table1((0.001, -0.001)).members
SPUR = replace(PINION, cone_angle=0.0, helix_angle=0.0)
FULL_ROUND = replace(
    PINION, tool=replace(PINION.tool, parabola=0.0, addendum=0.8, dedendum=1.4268180471, tip_radius=0.38)
)
"""The rounds of the tool meet within 4e-10 mm, so that there is no bottom land."""
LEFT_HAND = replace(PINION, helix_angle=-PINION.helix_angle)


@dataclass(frozen=True, eq=False)
class ReadBack:
    """A STEP file as read back: its shape and its named faces."""

    shape: Any
    faces: dict[str, Any]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder for solids; tests are skipped if the kernel is not installed."""
    pytest.importorskip("OCP", exc_type=ImportError)
    return tmp_path


def read_back(path: Path) -> ReadBack:
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPConstruct import STEPConstruct
    from OCP.STEPControl import STEPControl_Reader
    from OCP.StepShape import StepShape_AdvancedFace

    from beveloid_geom.export._brep import quiet_kernel

    with quiet_kernel():
        reader = STEPControl_Reader()
        assert reader.ReadFile(str(path)) == IFSelect_RetDone
        assert reader.TransferRoots() == 1
    model, process = reader.WS().Model(), reader.WS().TransferReader().TransientProcess()
    entities = [model.Value(i) for i in range(1, model.NbEntities() + 1)]
    faces = [entity for entity in entities if isinstance(entity, StepShape_AdvancedFace)]
    found = {face.Name().ToCString(): STEPConstruct.FindShape_s(process, face) for face in faces}
    return ReadBack(reader.OneShape(), found)


def explored(shape: Any, kind: str) -> list[Any]:
    from OCP import TopAbs
    from OCP.TopExp import TopExp_Explorer

    explorer, found = TopExp_Explorer(shape, getattr(TopAbs, f"TopAbs_{kind}")), []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def mass_of(shape: Any) -> tuple[float, FloatArray]:
    """Return volume and centre of mass."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, 1e-9)
    return float(properties.Mass()), np.array(properties.CentreOfMass().Coord())


def points_of(face: Any, count: int) -> FloatArray:
    """Return points (count, count, 3) of a face whose edges are parameter lines."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.TopoDS import TopoDS

    surface = BRepAdaptor_Surface(TopoDS.Face(face))
    u = np.linspace(surface.FirstUParameter(), surface.LastUParameter(), count)
    v = np.linspace(surface.FirstVParameter(), surface.LastVParameter(), count)
    points = [[surface.Value(float(a), float(b)) for b in v] for a in u]
    return np.array([[(p.X(), p.Y(), p.Z()) for p in row] for row in points])


def turned(points: FloatArray, angle: float) -> FloatArray:
    x, y, z = np.moveaxis(points, -1, 0)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack((x * cos - y * sin, x * sin + y * cos, z), axis=-1)


def parameter_at(surface: Exact, ends: tuple[Any, Any], points: FloatArray) -> FloatArray:
    """Return the parameter between the `ends` at which a surface has z and radius of points."""
    z, radius = points[..., 2], np.hypot(points[..., 0], points[..., 1])
    low, high = (np.broadcast_to(end, z.shape) for end in ends)
    for _ in range(50):
        middle = 0.5 * (low + high)
        below = np.hypot(*np.moveaxis(surface(middle, z)[0][..., :2], -1, 0)) < radius
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return low


def distance_from(surface: Exact, ends: tuple[Any, Any], points: FloatArray) -> float:
    """Return the largest distance of points from a surface, along the normals at equal z and radius."""
    exact, normals = surface(parameter_at(surface, ends, points), points[..., 2])
    assert np.linalg.norm(exact - points, axis=-1).max() < 1e-4
    return float(np.abs(np.einsum("...i,...i", exact - points, normals)).max())


def distance_to(shape: Any, points: FloatArray) -> FloatArray:
    """Return the distances (n,) of points (n, 3) from a shape, measured by the kernel, mm."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.gp import gp_Pnt

    vertices = [BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex() for point in points.tolist()]
    return np.array([BRepExtrema_DistShapeShape(vertex, shape).Value() for vertex in vertices])


@pytest.mark.slow
def test_faces_of_a_modified_gear_are_turned_by_the_depth(folder: Path) -> None:
    """The faces are the generated flanks of a helical gear, turned into the tooth by depth over base radius.

    The depth is computed from z and from the parameter of the generated flank at the same radius."""
    helical = replace(PINION, cone_angle=0.0, tool=replace(PINION.tool, parabola=0.0))
    reliefs: dict[str, Any] = {"heel_relief_um": 20.0, "heel_relief_length_mm": 10.0}
    reliefs |= {"tip_relief_um": 15.0, "tip_relief_length_mm": 2.5}
    write_step(helical.modified(Modification(helix_crowning_um=30.0, **reliefs)), folder / "gear.step", (0,))
    written = read_back(folder / "gear.step")
    tan_transverse = np.tan(float(helical.tool.normal_pressure_angle)) / np.cos(radians(25.0))
    base_radius = 6.0 * 29 / (2.0 * np.cos(radians(25.0))) / np.hypot(1.0, tan_transverse)
    for flank in ("right", "left"):
        points = points_of(written.faces[f"{flank} flank 1"], 25)
        z, (surface, ends) = points[..., 2], exact_places(helical, flank)["flank"]
        at_radius, tip = parameter_at(surface, ends(z), points), float(np.max(ends(np.zeros(1))[1]))
        depth = 0.030 * (z / 25.0) ** 2 + 0.020 * np.maximum(z - 15.0, 0.0) ** 2 / 10.0**2
        depth += 0.015 * np.maximum(at_radius - tip + 2.5, 0.0) ** 2 / 2.5**2
        angle = np.arctan2(points[..., 1], points[..., 0]) + flank_sign(flank) * depth / base_radius
        radius = np.hypot(points[..., 0], points[..., 1])
        generated = np.stack((radius * np.cos(angle), radius * np.sin(angle), z), axis=-1)
        assert distance_from(surface, ends(z), generated) < 2e-6


def measured_points(member: Member) -> tuple[Member, FloatArray]:
    """Return a member with measured deviations, and the measured points, (flanks, n, 3): those of the grid,
    displaced along their normals."""
    grid = measuring_grid(member, 7, 11)
    depth, face = np.linspace(-1.0, 1.0, 7)[:, None], np.linspace(-1.0, 1.0, 11)
    form = -12.0 * face**2 - 5.0 * depth**2, 4.0 * depth - 8.0 * face**2 + 3.0 * face * depth
    scatter = np.random.default_rng(3).normal(0.0, 0.5, (2, 7, 11))
    deviation_um = np.stack(form) + scatter
    deviations = FlankDeviations(l=grid.l, z=grid.point[..., 2], deviation_um=deviation_um)
    points = grid.point + 1e-3 * deviation_um[..., None] * grid.normal
    return member.modified(Modification(deviations=deviations)), points.reshape(2, -1, 3)


@pytest.mark.parametrize("member", [PINION, GEAR], ids=["pinion", "gear"])
def test_measured_points_lie_on_the_faces(member: Member, folder: Path) -> None:
    """Deviations are rotations about the axis, which are equal to displacements along the normal to first
    order."""
    measured, points = measured_points(member)
    write_step(measured, folder / "gear.step", (0,))
    faces = read_back(folder / "gear.step").faces
    for flank, of_flank in zip(("right", "left"), points, strict=True):
        assert distance_to(faces[f"{flank} flank 1"], of_flank).max() < 1e-4


BOTH_ENDS = {"heel_relief_um": 10.0, "heel_relief_length_mm": 17.3}
BOTH_ENDS |= {"toe_relief_um": 10.0, "toe_relief_length_mm": 32.7}


@pytest.mark.slow
@pytest.mark.parametrize("amounts", [BOTH_ENDS, {"tip_relief_um": 15.0, "tip_relief_length_mm": 40.0}])
def test_reliefs_that_begin_together_or_beyond_the_flank(amounts: dict[str, Any], folder: Path) -> None:
    """Heel and toe relief begin at the same place; the tip relief is longer than the flank."""
    write_step(PINION.modified(Modification(**amounts)), folder / "gear.step", (0,))
    assert "right flank 1" in read_back(folder / "gear.step").faces


CASES = {
    "pinion": (PINION, None, 29),
    "pinion, three teeth": (PINION, (-1, 0, 1), 3),
    "gear": (GEAR, None, 45),
    "gear, one tooth": (GEAR, (7,), 1),
    "spur": (SPUR, (0, 1, 2), 3),
    "left-hand": (LEFT_HAND, (0, 1, 2), 3),
    "left-hand, all but one": (LEFT_HAND, range(28), 28),
    "heel thin": (replace(PINION, cone_angle=radians(-3.0)), (0, 1), 2),
    "convex": (replace(PINION, tool=replace(PINION.tool, parabola=-0.004)), (0,), 1),
    "round tool": (FULL_ROUND, None, 29),
    "sharp tool": (replace(GEAR, tool=replace(GEAR.tool, tip_radius=0.0)), (0,), 1),
}
BORE = 40.0
TOOTH = ("left fillet", "left flank", "tip", "right flank", "right fillet")


@pytest.mark.parametrize(("member", "teeth", "count"), CASES.values(), ids=CASES)
def test_file_read_back_is_the_gear(
    folder: Path, member: Member, teeth: tuple[int, ...] | None, count: int
) -> None:
    from OCP.BRepCheck import BRepCheck_Analyzer

    path = folder / "gear.step"
    write_step(member, path, teeth, BORE)
    written = read_back(path)
    assert BRepCheck_Analyzer(written.shape).IsValid()
    assert len(explored(written.shape, "SOLID")) == len(explored(written.shape, "SHELL")) == 1
    assert mass_of(written.shape)[0] == pytest.approx(exact_volume(member, count, BORE), rel=1e-9)
    numbers, total = range(count) if teeth is None else teeth, int(member.teeth)
    complete = len(numbers) == total
    numbered = [number % total + 1 for number in numbers]
    names = {f"{name} {number}" for name in TOOTH for number in numbered} | {"toe", "heel", "bore"}
    names |= set() if complete else {"first side", "last side"}
    if member is not FULL_ROUND:
        names |= {f"bottom {number}" for number in (numbers[0] % total or total, *numbered)}
    assert set(written.faces) == names
    pitch = 2.0 * pi / float(member.teeth)
    for number in (numbers[0], numbers[-1]):
        for flank in ("right", "left"):
            for part, (surface, ends) in exact_places(member, flank).items():
                face = written.faces[f"{flank} {part} {number % total + 1}"]
                points = turned(points_of(face, 25), -number * pitch)
                assert distance_from(surface, ends(points[..., 2]), points) < 2e-6


def test_lands_and_bore_are_surfaces_of_revolution(folder: Path) -> None:
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.TopoDS import TopoDS

    write_step(PINION, folder / "cone.step", (3, 4))
    write_step(SPUR, folder / "cylinder.step", (3,), 20.0)
    cone, cylinder = read_back(folder / "cone.step").faces, read_back(folder / "cylinder.step").faces
    for name, offset in (("tip 4", 1.0 + 0.17), ("bottom 3", 0.17 - 1.25 / np.cos(radians(3.0)))):
        surface = BRepAdaptor_Surface(TopoDS.Face(cone[name])).Cone()
        radius = 6.0 * (29 / (2.0 * np.cos(radians(25.0))) + offset)
        slope = np.tan(surface.SemiAngle()) * surface.Axis().Direction().Z()
        assert slope == pytest.approx(np.tan(radians(3.0)), rel=1e-12)
        assert surface.RefRadius() - slope * surface.Location().Z() == pytest.approx(radius, rel=1e-12)
    for name, radius in (("tip 4", 6.0 * (14.5 + 1.17)), ("bottom 3", 6.0 * (14.5 - 1.08)), ("bore", 20.0)):
        found = BRepAdaptor_Surface(TopoDS.Face(cylinder[name])).Cylinder().Radius()
        assert found == pytest.approx(radius, rel=1e-12)


def test_nothing_is_written_to_standard_output(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The product has the name of the member and the number of teeth."""
    for name, teeth, product in (("gear", (0,), "gear, 1 of 29 teeth"), ("pinion", None, "pinion")):
        write_step(PINION, folder / "Zähne.step", teeth, name=name)
        assert capfd.readouterr() == ("", "")
        text = (folder / "Zähne.step").read_text(encoding="ascii")
        assert f"PRODUCT('{product}','{product}'," in text


def test_paths_need_not_be_utf8(folder: Path) -> None:
    odd = folder / os.fsdecode(b"bad\xff")
    try:
        odd.mkdir()
    except (OSError, UnicodeError):
        pytest.skip("this file system has names in UTF-8 only")
    for path in (odd / "tooth.step", folder / "tooth.step"):
        write_step(SPUR, path, [0])
    assert [one.name for one in odd.iterdir()] == ["tooth.step"]
    plain, odd_data = ((one / "tooth.step").read_bytes().split(b"DATA;", 1)[1] for one in (folder, odd))
    assert odd_data == plain


def test_the_pair_is_an_assembly_of_two_products_in_mesh(folder: Path) -> None:
    """Each gear is in its frame: its centre of mass on its axis, the contact point on its surface.

    Faces have their names. A single gear with a frame has the same position."""
    design = table1()
    pose = meshing_pair(design)
    write_step_pair(design, folder / "pair.step", pose.frames)
    write_step(design.gear, folder / "gear.step", name="gear", frame=pose.frames[1])
    text = (folder / "pair.step").read_text(encoding="ascii")
    assert [text.count(f"PRODUCT('{name}','{name}',") for name in ("pair", "pinion", "gear")] == [1, 1, 1]
    assert text.count("NEXT_ASSEMBLY_USAGE_OCCURRENCE") == 2
    pair, alone = read_back(folder / "pair.step"), read_back(folder / "gear.step")
    assert {"left flank 29", "left flank 45", "toe"} <= set(pair.faces)
    shells = [*explored(pair.shape, "SHELL"), *explored(alone.shape, "SHELL")]
    for shell, number in zip(shells, (0, 1, 1), strict=True):
        member, (rotation, origin) = design.members[number], pose.frames[number]
        volume, centre = mass_of(shell)
        exact = exact_volume(member, int(member.teeth), bore_of(member, None))
        assert volume == pytest.approx(exact, rel=1e-9)
        assert np.abs(((centre - origin) @ rotation)[:2]).max() < 1e-6
        assert distance_to(shell, pose.contact[None]) < 2e-6


def test_gmsh_shows_the_product_and_the_colours(folder: Path) -> None:
    """Gmsh and FreeCAD do not read names of faces, but they show the colours of the flanks."""
    from beveloid_geom.export._brep import COLOURS

    write_step(PINION, folder / "a.step", (0, 1), name="pinion")
    with opened_in_gmsh(folder / "a.step") as gmsh:
        [volume] = gmsh.model.getEntities(3)
        assert gmsh.model.getEntityName(*volume) == "Shapes/pinion, 2 of 29 teeth"
        seen = np.array([gmsh.model.getColor(*face)[:3] for face in gmsh.model.getEntities(2)])
    for colour in COLOURS.values():
        assert sum(np.abs(seen - 255.0 * np.array(colour)).max(axis=1) < 1.5) == 2
    assert sum(np.abs(seen - 255.0 * 0.75).max(axis=1) < 1.5) == len(seen) - 8


@pytest.mark.parametrize(
    ("change", "arguments", "text"),
    [
        ({"teeth": 8, "cone_angle": radians(20.0), "profile_shift": -0.5}, {}, "the right flank is undercut"),
        ({"profile_shift": 2.0}, {}, "the tooth tip is pointed"),
        ({"tool": replace(PINION.tool, dedendum=1.6)}, {}, "rounds overlap"),
        (
            {},
            {"bore_radius": 90.0},
            "bore_radius must be between 1.76387 and 87.5934 mm, got 90: 0.02 times the smallest root",
        ),
        ({}, {"tooth_numbers": (0, 2)}, r"tooth_numbers must be 1 to 29 successive numbers, got \[0, 2\]"),
        ({}, {"tooth_numbers": ()}, "tooth_numbers must be 1 to 29"),
        ({}, {"tooth_numbers": range(30)}, "tooth_numbers must be 1 to 29"),
        ({"cone_angle": 0.0, "face_width": 1400.0}, {}, "winds around the complete gear"),
    ],
)
def test_invalid_gears_are_rejected(
    folder: Path, change: dict[str, Any], arguments: dict[str, Any], text: str
) -> None:
    with pytest.raises(ValueError, match=text) as caught:
        write_step(replace(PINION, **change), folder / "gear.step", **arguments)
    assert "\n" not in str(caught.value)
    assert not list(folder.iterdir())


UNLOADED = "^Open CASCADE cannot be loaded"
NO_GL = "libGL.so.1: cannot open shared object file"


def raising(error: BaseException, cause: BaseException | None) -> type:
    """Return a finder of modules that raises an error for the kernel."""

    class Finder:
        @staticmethod
        def find_spec(name: str, *_: object) -> None:
            if name.partition(".")[0] == "OCP":
                raise error from cause

    return Finder


@pytest.mark.parametrize(
    ("error", "cause", "expected", "text"),
    [
        (ImportError(NO_GL), None, ImportError, f"{UNLOADED}: {NO_GL}.*sudo apt-get install libgl1"),
        (ImportError(NO_GL.replace("libGL", "libvtk")), None, ImportError, "libvtk.*: .*cadquery-ocp-novtk"),
        (ModuleNotFoundError("No module named 'vtk'", name="vtk"), None, ModuleNotFoundError, "vtk"),
        (ModuleNotFoundError("no OCP", name="OCP.gp"), None, ModuleNotFoundError, r"beveloid-geom\[step\]"),
        (ImportError("initialization failed"), KeyboardInterrupt(), KeyboardInterrupt, "^$"),
        (KeyboardInterrupt(), None, KeyboardInterrupt, "^$"),
    ],
)
def test_only_a_missing_kernel_is_reported_as_missing(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    cause: BaseException | None,
    expected: type[BaseException],
    text: str,
) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "OCP"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [raising(error, cause), *sys.meta_path])
    with pytest.raises(expected, match=text) as caught:
        write_step(PINION, tmp_path / "a.step", (0,))
    assert type(caught.value) is expected
