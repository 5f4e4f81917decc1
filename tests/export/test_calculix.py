"""A loaded tooth as CalculiX takes it: the deck runs as it is, and its answer is that of statics.

Skipped only where CalculiX (`ccx`, in Debian's calculix-ccx) is not installed."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import Design, tooth_hexahedra
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.placing import meshing_pair
from beveloid_geom.export.abaqus import FIXED_SETS
from beveloid_geom.export.parts import contact_case
from beveloid_geom.export.volumes import write_volume
from beveloid_geom.shapes.hexahedra import Cells
from tests.oracle.table1 import table1

CCX = shutil.which("ccx") or ""
pytestmark = pytest.mark.skipif(not CCX, reason="CalculiX is not installed: apt-get install calculix-ccx")
FORCE = 1000.0
SMALL = 1.0
FACE_WIDTH = 16.0
"""mm, of both gears: near-cubic elements and a converged answer with few of them."""
FEW = Cells(1, 2, 3, 4, 4)
REFINED = (Cells(1, 2, 2, 2, 2), Cells(1, 3, 4, 6, 6), Cells(1, 4, 6, 8, 8))
STRESSED = (Cells(1, 2, 2, 2, 2), Cells(1, 4, 4, 4, 4), Cells(1, 6, 6, 6, 6))
MOST_NODES = 30_000
FINE = Cells(1, 3, 5, 6, 8)
"""For a whole face; coarser elements under the load hide the hourglass modes."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What CalculiX printed: reactions (N) by set, the displacement (mm) of the observer, and
    the place of the observer and the force that was asked for."""

    nodes: int
    reaction: dict[str, FloatArray]
    displacement: FloatArray
    place: FloatArray
    force: FloatArray


def run(deck: Path) -> dict[str, FloatArray]:
    """The vectors that a deck has CalculiX print, by set."""
    done = subprocess.run(
        [CCX, "-i", deck.stem], cwd=deck.parent, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout[-2000:]
    for word in ("*ERROR", "*WARNING"):
        assert word not in done.stdout
    text = deck.with_suffix(".dat").read_text()
    numbers = r"\s+([-+.\dE]+)\s+([-+.\dE]+)\s+([-+.\dE]+)\n"
    head = r"(?:total force|displacements) \([^)]*\) for set (\w+) and time +0\.10+E\+01\n\n"
    found = re.findall(rf"{head}(?: +\d+(?= ))?{numbers}", text)
    return {name.lower(): np.array(vector, dtype=float) for name, *vector in found}


def narrow() -> Design:
    design = table1()
    pinion, gear = (replace(one, face_width=FACE_WIDTH) for one in design.members)
    return replace(design, pinion=pinion, gear=gear)


def solved(
    folder: Path, element: str, cells: Cells, member: int = 0, teeth: int = 1, flank: str = "right"
) -> Answer:
    design = narrow()
    pose = meshing_pair(design, flank)
    mesh = tooth_hexahedra(design.members[member], teeth, element, cells=cells)
    case = contact_case(mesh, design, pose, member, FORCE, (teeth - 1) // 2)
    deck = folder / "tooth.inp"
    write_volume(mesh, deck, element, case=case)
    printed = run(deck)
    place = mesh.points[case.observer]
    assert case.observer not in case.load.nodes
    opposite = {"right": "left", "left": "right"}[flank]
    assert case.observer in np.intersect1d(mesh.node_sets["tip"], mesh.node_sets[f"{opposite} flank"])
    return Answer(len(mesh.points), printed, printed.pop("observer"), place, case.load.total)


@pytest.mark.parametrize(
    ("element", "member", "teeth"), [("C3D20", 0, 1), ("C3D20R", 0, 1), ("C3D8I", 1, 3), ("C3D8", 0, 2)]
)
def test_reaction_is_the_load(tmp_path: Path, element: str, member: int, teeth: int) -> None:
    """Of the one set that holds all that is fixed; the force is that along the flank's normal."""
    answer = solved(tmp_path, element, FEW, member, teeth)
    assert set(answer.reaction) == {"fixed", *(name.replace(" ", "_") for name in FIXED_SETS)}
    assert np.linalg.norm(answer.force) == pytest.approx(FORCE, rel=1e-12)
    np.testing.assert_allclose(answer.reaction["fixed"], -answer.force, rtol=0, atol=1e-6 * FORCE)


@pytest.mark.parametrize("element", ["C3D20", pytest.param("C3D20R", marks=pytest.mark.slow)])
def test_displacement_of_an_unloaded_point_converges(tmp_path: Path, element: str) -> None:
    """At the tip of the opposite flank."""
    answers = [solved(tmp_path, element, cells, flank="left") for cells in REFINED]
    assert [answer.nodes for answer in answers] == sorted(answer.nodes for answer in answers)
    assert answers[-1].nodes < MOST_NODES
    for answer in answers:
        np.testing.assert_allclose(answer.place, answers[0].place, rtol=0, atol=1e-9)
    coarse, middle, fine = (answer.displacement for answer in answers)
    size = np.linalg.norm(fine)
    assert np.linalg.norm(fine - middle) < 0.2 * np.linalg.norm(middle - coarse)
    assert np.linalg.norm(fine - middle) < 0.01 * size
    assert 0.0 < fine @ answers[-1].force / (size * FORCE) <= 1.0


def mises(results: Path) -> FloatArray:
    """Von Mises stress (n,), MPa, of the nodes in CalculiX's file of results."""
    found: dict[int, list[float]] = {}
    stresses = False
    for line in results.read_text().splitlines():
        if line.startswith(" -4"):
            stresses = line.split()[1] == "STRESS"
        elif line.startswith(" -1") and stresses:
            found[int(line[3:13])] = [float(line[k : k + 12]) for k in range(13, 85, 12)]
    x, y, z, xy, yz, zx = np.array([found[node] for node in sorted(found)]).T
    direct = 0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2)
    return np.asarray(np.sqrt(direct + 3.0 * (xy**2 + yz**2 + zx**2)))


@pytest.mark.parametrize("flank", ["right", pytest.param("left", marks=pytest.mark.slow)])
def test_fillet_stress_and_balance_converge(tmp_path: Path, flank: str) -> None:
    """Greatest stress of the fillet's nodes on the loaded side, over three meshes: of the right flank 21.3,
    22.9, 23.7 MPa (a cut ellipse), of the left 22.2, 23.6, 24.1."""
    design, found, size = narrow(), [], 0
    pose = meshing_pair(design, flank)
    for cells in STRESSED:
        mesh = tooth_hexahedra(design.gear, 1, cells=cells)
        case = contact_case(mesh, design, pose, 1, FORCE)
        assert case.load.cut == (flank == "right")
        deck = tmp_path / "tooth.inp"
        write_volume(mesh, deck, "C3D20", case=case)
        np.testing.assert_allclose(run(deck)["fixed"], -case.load.total, rtol=0, atol=1e-6 * FORCE)
        found.append(mises(deck.with_suffix(".frd"))[mesh.node_sets[f"{flank} fillet"]].max())
        assert len(mesh.points) > 2 * size
        size = len(mesh.points)
    coarse, middle, fine = found
    assert abs(fine - middle) < 0.5 * abs(middle - coarse)
    assert fine == pytest.approx(middle, rel=0.035)


def test_a_point_would_take_more_of_the_fillet(tmp_path: Path) -> None:
    """A force of 1 N has next to a point for its ellipse: 1.28 times the stress that 1000 N make for each N
    on the long ellipse of the right flanks."""
    design, stress = table1(), []
    mesh = tooth_hexahedra(design.gear, 1, cells=FINE)
    for force in (SMALL, FORCE):
        case = contact_case(mesh, design, meshing_pair(design), 1, force)
        write_volume(mesh, tmp_path / "tooth.inp", "C3D20", case=case)
        run(tmp_path / "tooth.inp")
        stress.append(mises(tmp_path / "tooth.frd")[mesh.node_sets["right fillet"]].max() / force)
    assert stress[0] / stress[1] == pytest.approx(1.28, abs=0.02)


def test_a_whole_gear_is_held_in_its_bore_alone(tmp_path: Path) -> None:
    """All teeth asked for: nothing is cut, no node there twice."""
    design = narrow()
    mesh = tooth_hexahedra(design.pinion, 29, "C3D8", cells=Cells(1, 2, 1, 2, 2))
    assert len(np.unique(np.round(mesh.points, 6), axis=0)) == len(mesh.points)
    case = contact_case(mesh, design, meshing_pair(design), 0, FORCE, 14)
    assert case.fixed == ("bore",)
    write_volume(mesh, tmp_path / "gear.inp", "C3D8", case=case)
    printed = run(tmp_path / "gear.inp")
    np.testing.assert_allclose(printed["fixed"], -case.load.total, rtol=0, atol=1e-6 * FORCE)
    assert set(printed) == {"fixed", "bore", "observer"}


def stress_at_the_ends(folder: Path, element: str) -> dict[str, float]:
    """Greatest stress at toe and heel of a gear tooth loaded near mid-face, in parts of that in the
    fillet of its loaded side. Of a small force: its ellipse is smaller than a face."""
    design = table1()
    mesh = tooth_hexahedra(design.gear, 1, element, cells=FINE)
    case = contact_case(mesh, design, meshing_pair(design), 1, SMALL)
    assert abs(case.load.point[2]) < 2.0
    deck = folder / "tooth.inp"
    write_volume(mesh, deck, element, case=case)
    run(deck)
    stress = mises(deck.with_suffix(".frd"))
    assert len(stress) == len(mesh.points)
    fillet = stress[mesh.node_sets["right fillet"]].max()
    assert 10.0 < fillet * FORCE / SMALL < 25.0
    return {name: float(stress[mesh.node_sets[name]].max() / fillet) for name in ("toe", "heel")}


def test_stress_dies_away_from_the_load(tmp_path: Path) -> None:
    """The default element. At the toe, where the tooth is smaller, 11 % are left, on finer meshes too."""
    ends = stress_at_the_ends(tmp_path, "C3D20")
    assert ends["toe"] < 0.15
    assert ends["heel"] < 0.1


@pytest.mark.slow
def test_reduced_integration_does_not_let_it(tmp_path: Path) -> None:
    """Why C3D20R is not the default: the hourglass modes that a load on one face wakes reach toe and
    heel, with more stress at the heel than in the fillet."""
    ends = stress_at_the_ends(tmp_path, "C3D20R")
    assert ends["toe"] > 0.3
    assert ends["heel"] > 1.0
