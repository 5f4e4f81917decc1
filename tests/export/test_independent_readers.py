"""Files read by programs that share no code with this one.

These are lib3mf, ADMesh, the glTF validator of Khronos, Gmsh and pyNastran.

A test is skipped if its program is not installed; `.ci/run` installs all of them.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
import trimesh

from beveloid_geom import tooth_hexahedra
from beveloid_geom.arrays import Indices
from beveloid_geom.contact.mesh_position import MeshingPair, meshing_pair
from beveloid_geom.export import identifier, parts
from beveloid_geom.export.fea.volumes import write_volume
from beveloid_geom.export.scene import pair_scene, write_glb
from beveloid_geom.export.surfaces import SurfaceMesh, write_surface
from beveloid_geom.shapes.element_sizes import Cells
from beveloid_geom.shapes.hexahedral_mesh import VolumeMesh
from tests.export.gmsh_model import opened_in_gmsh
from tests.oracle.table1 import table1

pytestmark = pytest.mark.slow
DESIGN = table1((0.001, -0.001))
ADMESH, NODE = shutil.which("admesh"), shutil.which("node")
VALIDATE = """
const validator = require("gltf-validator");
const bytes = new Uint8Array(require("fs").readFileSync(process.argv[1]));
validator.validateBytes(bytes).then(report => console.log(JSON.stringify(report)));
"""


@lru_cache(maxsize=1)
def position() -> MeshingPair:
    return meshing_pair(DESIGN)


def surface(part: str, suffix: str) -> SurfaceMesh:
    """Return the pair, the complete gear or two teeth of the pinion."""
    if part == "pair":
        return parts.pair_surface(DESIGN, position().frames, suffix, 0.1)
    if part == "gear":
        return parts.gear_surface(DESIGN.gear, suffix, 0.1)
    return parts.gear_surface(DESIGN.pinion, suffix, 0.05, 2)


@pytest.mark.parametrize("part", ["pair", "teeth"])
def test_lib3mf_in_strict_mode(tmp_path: Path, part: str) -> None:
    """lib3mf, the reference implementation of 3MF, reads the file in strict mode."""
    lib3mf = pytest.importorskip("lib3mf", reason="pip install lib3mf")
    write_surface(surface(part, ".3mf"), tmp_path / "a.3mf", title="tooth")
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(tmp_path / "a.3mf"))
    assert reader.GetWarningCount() == 0
    objects, names = model.GetMeshObjects(), []
    while objects.MoveNext():
        one = objects.GetCurrentMeshObject()
        assert one.IsManifoldAndOriented()
        names.append(one.GetName())
    assert names == (["pinion", "gear"] if part == "pair" else ["beveloid-geom tooth"])
    assert model.GetBuildItems().Count() == len(names)


@pytest.mark.skipif(ADMESH is None, reason="apt-get install admesh")
@pytest.mark.parametrize("part", ["pair", "gear", "teeth"])
def test_admesh_finds_nothing_to_repair(tmp_path: Path, part: str) -> None:
    mesh, path = surface(part, ".stl"), tmp_path / "a.stl"
    write_surface(mesh, path)
    read = subprocess.run([str(ADMESH), path], capture_output=True, text=True, timeout=300)
    assert read.returncode == 0, read.stderr
    numbers = {name.strip(): text for name, text in re.findall(r"([A-Z][\w ]+?) *: +([-\d.]+)", read.stdout)}
    volume = float(numbers.pop("Volume"))
    assert volume == pytest.approx(trimesh.Trimesh(mesh.points, mesh.faces, process=False).volume, rel=1e-5)
    assert numbers.pop("Number of facets") == str(len(mesh.faces))
    assert numbers.pop("Number of parts") == str({"pair": 2}.get(part, 1))
    assert len(numbers) >= 9
    assert set(numbers.values()) == {"0"}, numbers


def test_gltf_validator_has_no_error_and_no_warning(tmp_path: Path) -> None:
    """The validator of Khronos, the maintainer of glTF, reports no error and no warning."""
    node = NODE or "node"
    if not NODE or subprocess.run([node, "-e", "require('gltf-validator')"], capture_output=True).returncode:
        pytest.skip("npm install gltf-validator, with NODE_PATH set to the folder of its modules")
    scene = pair_scene(DESIGN, position(), position().frames, 0.1)
    write_glb(scene, tmp_path / "a.glb")
    done = subprocess.run([node, "-e", VALIDATE, str(tmp_path / "a.glb")], capture_output=True, text=True)
    report = json.loads(done.stdout)
    issues = report["issues"]
    found = issues["numErrors"], issues["numWarnings"], issues["truncated"]
    assert found == (0, 0, False), issues["messages"]
    assert report["info"]["drawCallCount"] == len(scene) >= 6  # two gears, each with a path and a pattern


@lru_cache(maxsize=2)
def tooth(element: str) -> VolumeMesh:
    return tooth_hexahedra(DESIGN.gear, 1, element, cells=Cells(2, 2, 3, 6, 6))


@lru_cache(maxsize=1)
def volume_of_triangles() -> float:
    """Return the volume of the same tooth between its triangulated surfaces, mm^3."""
    solid = parts.gear_surface(DESIGN.gear, ".stl", 0.1, 1)
    return float(trimesh.Trimesh(solid.points, solid.faces, process=False).volume)


@pytest.mark.parametrize("element", ["C3D8", "C3D20"])
def test_gmsh_reads_sets_and_elements(tmp_path: Path, element: str) -> None:
    mesh = tooth(element)
    write_volume(mesh, tmp_path / "a.msh", element)
    with opened_in_gmsh(tmp_path / "a.msh") as gmsh:
        groups = {gmsh.model.getPhysicalName(*group): group for group in gmsh.model.getPhysicalGroups()}
        for name in ("right flank", "left fillet", "tip", "bore", "heel", "last side"):
            nodes, _ = gmsh.model.mesh.getNodesForPhysicalGroup(*groups[identifier(name)])
            np.testing.assert_array_equal(np.sort(nodes) - 1, mesh.node_sets[name])
        kinds, elements, _ = gmsh.model.mesh.getElements(3)
        assert kinds.tolist() == [{"C3D8": 5, "C3D20": 17}[element]]
        assert len(elements[0]) == len(mesh.hexahedra)
        assert min(gmsh.model.mesh.getElementQualities(elements[0], "minSJ")) > 0.3
        volume = gmsh.model.mesh.getElementQualities(elements[0], "volume").sum()
        assert volume == pytest.approx(volume_of_triangles(), rel=2e-3)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("element", ["C3D8", "C3D20"])
def test_pynastran_reads_sets_and_elements(tmp_path: Path, element: str) -> None:
    """pyNastran also resolves all references between nodes, elements, property and material."""
    bdf = pytest.importorskip("pyNastran.bdf.bdf", reason="pip install pyNastran; it needs NumPy below 2.4")
    mesh = tooth(element)
    write_volume(mesh, tmp_path / "a.bdf", element)
    model = bdf.BDF(debug=False)
    model.read_bdf(str(tmp_path / "a.bdf"), validate=True, xref=True)
    points = np.array([model.nodes[number + 1].get_position() for number in range(len(mesh.points))])
    np.testing.assert_allclose(points, mesh.points, rtol=0, atol=6e-11)
    hexahedra = [model.elements[number + 1].node_ids for number in range(len(mesh.hexahedra))]
    np.testing.assert_array_equal(np.array(hexahedra) - 1, nastran_order(mesh.hexahedra))
    volume = sum(one.Volume() for one in model.elements.values())  # mean area of faces times height
    assert volume == pytest.approx(volume_of_triangles(), rel=0.02)
    subcase = model.case_control_deck.subcases[0]
    sets = [value for key, (value, *_) in subcase.params.items() if key.startswith("SET")]
    assert sorted(map(sorted, sets)) == sorted((nodes + 1).tolist() for nodes in mesh.node_sets.values())


def nastran_order(hexahedra: Indices) -> Indices:
    """Nastran lists the mid-side nodes between the faces before those of the upper face."""
    if hexahedra.shape[1] == 8:
        return hexahedra
    return hexahedra[:, [*range(12), *range(16, 20), *range(12, 16)]]
