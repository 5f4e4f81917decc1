"""A loaded tooth in CalculiX: the deck runs as it is; reactions, displacements and stresses are checked."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import Design, tooth_hexahedra
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export.fea.abaqus import FIXED_SETS, LoadCase
from beveloid_geom.export.fea.volumes import write_volume
from beveloid_geom.export.parts import contact_case
from beveloid_geom.shapes.element_sizes import Cells
from beveloid_geom.shapes.hexahedral_mesh import VolumeMesh
from tests.export.fea.ccx import mises, narrow, run_ccx, with_ccx
from tests.oracle.table1 import table1

pytestmark = with_ccx
FORCE = 1000.0
SMALL = 1.0
NARROW = narrow(16.0)
"""On this narrow face a mesh of few elements has nearly cubic elements and converged results."""
FEW = Cells(1, 2, 3, 4, 4)
REFINED = (Cells(1, 2, 2, 2, 2), Cells(1, 3, 4, 6, 6), Cells(1, 4, 6, 8, 8))
STRESSED = (Cells(1, 2, 2, 2, 2), Cells(1, 4, 4, 4, 4), Cells(1, 6, 6, 6, 6))
MOST_NODES = 30_000
FINE = Cells(1, 3, 5, 6, 8)
"""For a complete face; coarser elements under the load hide the hourglass modes."""


def run(deck: Path) -> dict[str, FloatArray]:
    """Run a deck and return the printed vectors by set."""
    run_ccx(deck)
    text = deck.with_suffix(".dat").read_text()
    numbers = r"\s+([-+.\dE]+)\s+([-+.\dE]+)\s+([-+.\dE]+)\n"
    head = r"(?:total force|displacements) \([^)]*\) for set (\w+) and time +0\.10+E\+01\n\n"
    found = re.findall(rf"{head}(?: +\d+(?= ))?{numbers}", text)
    return {name.lower(): np.array(vector, dtype=float) for name, *vector in found}


@dataclass(frozen=True, eq=False)
class Solved:
    """Loaded tooth with the output of CalculiX: reactions (N) by set, displacement (mm) of the observer."""

    mesh: VolumeMesh
    case: LoadCase
    printed: dict[str, FloatArray]
    results: Path

    def stress(self, name: str) -> float:
        """Return the largest von Mises stress (MPa) of the nodes of a set."""
        stresses = mises(self.results)
        assert len(stresses) == len(self.mesh.points)
        return float(stresses[self.mesh.node_sets[name]].max())


def solved(
    folder: Path,
    design: Design,
    cells: Cells,
    element: str = "C3D20",
    *,
    member: int = 1,
    teeth: int = 1,
    flank: str = "right",
    force: float = FORCE,
) -> Solved:
    """Solve a loaded tooth, of the gear by default, and check that the reaction equals the load."""
    mesh = tooth_hexahedra(design.members[member], teeth, element, cells=cells)
    case = contact_case(mesh, design, meshing_pair(design, flank), member, force, (teeth - 1) // 2)
    deck = folder / "tooth.inp"
    write_volume(mesh, deck, element, case=case)
    printed = run(deck)
    np.testing.assert_allclose(printed["fixed"], -case.load.total, rtol=0, atol=1e-6 * force)
    assert np.linalg.norm(case.load.total) == pytest.approx(force, rel=1e-12)
    return Solved(mesh, case, printed, deck.with_suffix(".frd"))


@pytest.mark.parametrize(
    ("element", "member", "teeth"), [("C3D20", 0, 1), ("C3D20R", 0, 1), ("C3D8I", 1, 3), ("C3D8", 0, 2)]
)
def test_reaction_is_the_load(tmp_path: Path, element: str, member: int, teeth: int) -> None:
    """Reactions are printed for all fixed nodes and for each fixed set."""
    found = solved(tmp_path, NARROW, FEW, element, member=member, teeth=teeth)
    sets = (name.replace(" ", "_") for name in FIXED_SETS)
    assert set(found.printed) == {"observer", "fixed", *sets}


@pytest.mark.parametrize("element", ["C3D20", pytest.param("C3D20R", marks=pytest.mark.slow)])
def test_displacement_of_an_unloaded_point_converges(tmp_path: Path, element: str) -> None:
    """The observed point is at the tip of the opposite flank."""
    answers = [solved(tmp_path, NARROW, cells, element, member=0, flank="left") for cells in REFINED]
    sizes = [len(one.mesh.points) for one in answers]
    assert sizes == sorted(sizes)
    assert sizes[-1] < MOST_NODES
    for one in answers:
        observer, sets = one.case.observer, one.mesh.node_sets
        assert observer not in one.case.load.nodes
        assert observer in np.intersect1d(sets["tip"], sets["right flank"])
        first = answers[0].mesh.points[answers[0].case.observer]
        np.testing.assert_allclose(one.mesh.points[observer], first, rtol=0, atol=1e-9)
    coarse, middle, fine = (one.printed["observer"] for one in answers)
    size = np.linalg.norm(fine)
    assert np.linalg.norm(fine - middle) < 0.2 * np.linalg.norm(middle - coarse)
    assert np.linalg.norm(fine - middle) < 0.01 * size
    assert 0.0 < fine @ answers[-1].case.load.total / (size * FORCE) <= 1.0


@pytest.mark.parametrize("flank", ["right", pytest.param("left", marks=pytest.mark.slow)])
def test_fillet_stress_and_balance_converge(tmp_path: Path, flank: str) -> None:
    """Largest stress of the fillet on the loaded side, for three meshes.

    For the right flank, with a cut ellipse, it is 21.3, 22.9 and 23.7 MPa, for the left flank 22.2, 23.6 and
    24.1."""
    stresses, size = [], 0
    for cells in STRESSED:
        one = solved(tmp_path, NARROW, cells, flank=flank)
        assert one.case.load.cut == (flank == "right")
        stresses.append(one.stress(f"{flank} fillet"))
        assert len(one.mesh.points) > 2 * size
        size = len(one.mesh.points)
    coarse, middle, fine = stresses
    assert abs(fine - middle) < 0.5 * abs(middle - coarse)
    assert fine == pytest.approx(middle, rel=0.035)


def test_a_small_contact_causes_more_fillet_stress(tmp_path: Path) -> None:
    """The stress per newton under 1 N, which acts almost at a point, is 1.28 times that under 1000 N.

    The larger force acts on the long ellipse of the right flanks."""
    forces = SMALL, FORCE
    stress = [solved(tmp_path, table1(), FINE, force=f).stress("right fillet") / f for f in forces]
    assert stress[0] / stress[1] == pytest.approx(1.28, abs=0.02)


def test_a_complete_gear_is_held_only_in_its_bore(tmp_path: Path) -> None:
    """With all teeth there are no cut sides and no duplicate nodes."""
    found = solved(tmp_path, NARROW, Cells(1, 2, 1, 2, 2), "C3D8", member=0, teeth=29)
    points = found.mesh.points
    assert len(np.unique(np.round(points, 6), axis=0)) == len(points)
    assert found.case.fixed == ("bore",)
    assert set(found.printed) == {"fixed", "bore", "observer"}


def stress_at_the_ends(folder: Path, element: str) -> dict[str, float]:
    """Return the largest stresses at toe and heel, divided by that of the fillet, of a tooth loaded near
    mid-face.

    The force is small, so that its ellipse is smaller than a face of an element."""
    found = solved(folder, table1(), FINE, element, force=SMALL)
    assert abs(found.case.load.point[2]) < 2.0
    fillet = found.stress("right fillet")
    assert 10.0 < fillet * FORCE / SMALL < 25.0
    return {name: found.stress(name) / fillet for name in ("toe", "heel")}


def test_stress_decreases_away_from_the_load(tmp_path: Path) -> None:
    """With the default element, the stress at toe and heel is small. At the toe, where the tooth is smaller,
    11 % of the fillet stress remain, also for finer meshes."""
    ends = stress_at_the_ends(tmp_path, "C3D20")
    assert ends["toe"] < 0.15
    assert ends["heel"] < 0.1


@pytest.mark.slow
def test_reduced_integration_has_hourglass_modes(tmp_path: Path) -> None:
    """C3D20R is not the default, because a load on one face causes hourglass modes that reach toe and heel.

    The stress at the heel exceeds that of the fillet."""
    ends = stress_at_the_ends(tmp_path, "C3D20R")
    assert ends["toe"] > 0.3
    assert ends["heel"] > 1.0
