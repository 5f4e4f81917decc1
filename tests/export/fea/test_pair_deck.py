"""The pair in contact: mesh and input file, and results of CalculiX against statics and Hertz."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from beveloid_geom import Design
from beveloid_geom.contact.ellipse import relative_curvature
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export.fea.load import ContactPlace, contact_load
from beveloid_geom.export.fea.pair_deck import write_pair_deck
from beveloid_geom.export.fea.pair_mesh import PairMesh, force_lever, pair_mesh
from beveloid_geom.export.fea.pair_results import PairResult, read_pair_result
from beveloid_geom.shapes.element_sizes import Cells
from beveloid_geom.shapes.hexahedral_mesh import face_nodes
from tests.export.fea.ccx import mises, narrow, run_ccx, with_ccx
from tests.oracle.table1 import table1
from tests.symmetry import scaled as similar

NARROW = narrow(12.0)
"""For a small mesh and a contact along the complete face."""
FORCE = 5000.0
SMALL = {"cells": Cells(1, 2, 3, 2, 2), "across": 0.5, "bore_radii": (84.0, 84.0), "force": FORCE}
PITCH = 2.0 * np.pi / 29.0


def scaled(module: float) -> Design:
    """Return the pair of Table 1 with faces of 20 mm at module 6 mm, scaled to another module."""
    return similar(narrow(20.0), module / 6.0)


def meshed(flank: str = "right", pitches: float = 0.0) -> PairMesh:
    """Return the narrow pair at a roll that is `pitches` away from the middle of its path."""
    design = NARROW
    pose = meshing_pair(design, flank)
    return pair_mesh(design, pose, float(pose.roll[0]) + pitches * PITCH, **SMALL)  # type: ignore[arg-type]


def solved(folder: Path, pair: PairMesh, force: float = FORCE, design: Design = NARROW) -> PairResult:
    """Return the result of CalculiX for the torque of a force between unmodified flanks."""
    deck = folder / "pair.inp"
    write_pair_deck(deck, design, pair, force * force_lever(design))
    run_ccx(deck)
    return read_pair_result(deck)


def test_the_mesh_of_both_members() -> None:
    """The mesh has no duplicate nodes, and the reference nodes are on the axes. Each tooth is near its mate;
    the middle teeth are nearest."""
    pair = meshed(pitches=0.2)
    mesh = pair.mesh
    assert len(np.unique(np.round(mesh.points, 6), axis=0)) == len(mesh.points)
    reference = [mesh.node_sets[f"{name} reference"] for name in ("pinion", "gear")]
    assert np.array_equal(np.concatenate(reference), len(mesh.points) - np.array([2, 1]))
    assert np.array_equal(np.unique(mesh.hexahedra), np.arange(len(mesh.points) - 2))
    for (_, origin), (node,) in zip(pair.frames, reference, strict=True):
        assert np.array_equal(mesh.points[node], origin)
    assert pair.contacts == tuple((f"pinion right flank {k}", f"gear right flank {4 - k}") for k in (1, 2, 3))
    middles = {name: mesh.points[face_nodes(mesh, own)].mean(axis=1) for name, own in mesh.surfaces.items()}
    gaps = [np.min(cKDTree(middles[one]).query(middles[other])[0]) for one, other in pair.contacts]
    assert np.argmin(gaps) == 1
    assert max(gaps) < 20.0  # neighbours face each other, a base pitch of 18 mm apart at most


def test_the_contact_lies_on_both_meshes(flank: str) -> None:
    """The faces of the middle teeth are within 0.1 um of the contact point of the path."""
    design = table1()
    pose = meshing_pair(design, flank)
    pair, relative = pair_mesh(design, pose, force=20e3), relative_curvature(pose.path)
    for name, sense in zip(pair.contacts[1], (1.0, -1.0), strict=True):
        normal = sense * pose.path.normal[1]
        place = ContactPlace(pose.contact, normal, relative.curvature[1], relative.direction[1])
        assert contact_load(pair.mesh, name, place, 20e3).gap < 1e-4


def test_flanks_that_touch_are_finer() -> None:
    """Half a pitch from the middle of the path, two tooth pairs touch, and both have fine elements."""
    for pitches, fine in ((0.0, [0, 1, 0]), (0.5, [1, 1, 0]), (-0.5, [0, 1, 1])):
        pair = meshed(pitches=pitches)
        for names in zip(*pair.contacts, strict=True):
            rows = np.array([len(pair.mesh.surfaces[name]) for name in names])
            assert (rows > rows.min()).tolist() == fine


def test_the_deck_is_flat_and_names_what_a_reader_needs(tmp_path: Path) -> None:
    pair = meshed("left")
    write_pair_deck(tmp_path / "a.inp", NARROW, pair, 1e5, ["a comment"])
    text = (tmp_path / "a.inp").read_text(encoding="ascii")
    assert not re.search(r"^\*(PART|INSTANCE|ASSEMBLY)", text, re.MULTILINE)
    assert text.count("*CONTACT PAIR") == text.count("*CONTACT PRINT") == 3
    assert f"pinion_reference, 6, {-1e5:.12g}\n" in text  # against the clock presses the left flanks
    for name in ("pinion_left_flank_2", "gear_right_fillet_1", "pinion_hub", "gear_reference", "pinion_body"):
        assert len(re.findall(rf"={name}(,|\n)", text)) >= 1, name
    with pytest.raises(FileNotFoundError):
        read_pair_result(tmp_path / "a.inp")
    (tmp_path / "a.dat").write_text("")
    with pytest.raises(ValueError, match=r"has not completed .*a.inp: see"):
        read_pair_result(tmp_path / "a.inp")
    (tmp_path / "b.inp").write_text("*NODE\n")
    with pytest.raises(ValueError, match=r"b.inp is not a deck of a pair in contact"):
        read_pair_result(tmp_path / "b.inp")


def test_similar_pairs_have_similar_decks(flank: str) -> None:
    """Pairs of all modules have the same elements, and a contact stiffness that is inversely proportional to
    the module."""
    decks = []
    for module in (6.0, 0.3, 20.0):
        design, scale = scaled(module), module / 6.0
        pair = pair_mesh(design, meshing_pair(design, flank), teeth=1, force=8e3 * scale**2, across=0.5)
        decks.append((pair.mesh.points / scale, pair.stiffness * scale, pair.across, pair.along))
    for points, *numbers in decks[1:]:
        np.testing.assert_allclose(points, decks[0][0], rtol=0, atol=1e-6)
        assert numbers == pytest.approx(decks[0][1:], rel=1e-9)
    assert 3e5 < decks[0][1] < 3e6  # N/mm^3: 1000 MPa compress the contact by some 1 um


def test_a_coarse_tolerance_is_no_finer_than_none() -> None:
    design = table1()
    pose = meshing_pair(design)
    nodes = [
        len(pair_mesh(design, pose, teeth=1, force=20e3, across=0.5, tolerance=tolerance).mesh.points)
        for tolerance in (None, 10.0, 0.1, 0.05)
    ]
    assert nodes[0] == nodes[1] <= nodes[2] < nodes[3]


def test_members_have_bores_of_their_own() -> None:
    design = table1()
    bores = {"pinion": 60.0, "gear": 110.0}
    pair = pair_mesh(design, meshing_pair(design), teeth=1, force=20e3, across=0.2, bore_radii=(60.0, 110.0))
    for (rotation, origin), (member, radius) in zip(pair.frames, bores.items(), strict=True):
        points = pair.mesh.points[pair.mesh.node_sets[f"{member} bore"]] - origin
        found = np.linalg.norm(np.cross(points, rotation[:, 2]), axis=1)
        np.testing.assert_allclose(found, radius, rtol=1e-12)


@pytest.mark.parametrize(
    ("roll", "teeth", "message"),
    [
        (1.0, 3, "roll_deg must be between 0.1924 and 18.7682 deg, where tooth pair 0 is in mesh"),
        (None, 2, "teeth must be an odd number from 1 to 29 for the pair, got 2"),
        (None, 31, "teeth must be an odd number from 1 to 29 for the pair, got 31"),
        (0.26, 1, "teeth must be at least 3 to include all teeth that touch at this roll, got 1"),
    ],
)
def test_invalid_rolls_and_numbers_of_teeth_are_rejected(
    roll: float | None, teeth: int, message: str
) -> None:
    design = NARROW
    with pytest.raises(ValueError, match=message):
        pair_mesh(design, meshing_pair(design), roll, teeth=teeth, force=FORCE)


def test_an_unknown_first_contact_is_named() -> None:
    pinion, gear = (replace(m, tip_alteration=0.3) for m in table1().members)
    design = Design(pinion, gear, table1().pair)
    message = (
        r"^the first contact of the right flanks is not known: a tip reaches the other member's bottom land$"
    )
    with pytest.raises(ValueError, match=message):
        pair_mesh(design, meshing_pair(design), force=FORCE)


@with_ccx
@pytest.mark.parametrize(
    ("flank", "pitches"),
    [("right", 0.0), ("left", 0.3), pytest.param("right", -0.4, marks=pytest.mark.slow)],
)
def test_torques_are_as_the_numbers_of_teeth(tmp_path: Path, flank: str, pitches: float) -> None:
    """The moments about both axes have the ratio N2 / N1, because the flanks are conjugate and have no
    friction. The forces along the common normal add up to torque over lever. Away from the middle, two tooth
    pairs share them."""
    design, pair = NARROW, meshed(flank, pitches)
    result = solved(tmp_path, pair)
    pinion, gear = result.moment.sum(axis=0)
    assert -pinion * (1.0 if flank == "right" else -1.0) == pytest.approx(result.torque, rel=1e-3)
    assert abs(gear / pinion) == pytest.approx(45.0 / 29.0, rel=2e-3)
    normal = meshing_pair(design, flank).path.normal[1]
    assert -result.force.sum(axis=0) @ normal == pytest.approx(FORCE, rel=5e-3)
    assert (result.share > 0.01).sum() == (1 if pitches == 0.0 else 2)
    assert result.share.sum() == pytest.approx(1.0, abs=1e-12)
    assert result.turn > 0.0


@with_ccx
def test_a_light_load_leaves_the_rigid_contact(tmp_path: Path) -> None:
    """Under 1 % of the load, the pinion has rotated by less than 1 um at its pitch circle from the rigid
    contact."""
    pair = meshed()
    light = solved(tmp_path, pair, 0.01 * FORCE)
    assert 0.0 < light.turn * 96.9 < 1e-3


@with_ccx
@pytest.mark.slow
def test_fillet_stress_converges(tmp_path: Path) -> None:
    """The largest von Mises stresses of the loaded fillets at mid-face converge. Two meshes, refined
    everywhere, are compared with the stored result of a third one, Cells(4, 7, 7, 7, 2): 186.7 MPa on the
    pinion and 165.6 MPa on the gear."""
    design, stresses = NARROW, []
    pose, fine = meshing_pair(design), np.array((186.7, 165.6))
    for cells in (Cells(2, 3, 3, 3, 2), Cells(3, 5, 5, 5, 2)):
        pair = pair_mesh(design, pose, teeth=1, force=FORCE, cells=cells, across=1.0, bore_radii=(82.0, 82.0))
        solved(tmp_path, pair)
        stress = mises(tmp_path / "pair.frd")
        for name, (rotation, origin) in zip(("pinion", "gear"), pair.frames, strict=True):
            nodes = pair.mesh.node_sets[f"{name} right fillet"]
            z = (pair.mesh.points[nodes] - origin) @ rotation[:, 2]
            stresses.append(float(stress[nodes[np.abs(z) < 1e-6]].max()))
    coarse, middle = np.reshape(stresses, (2, 2))
    assert (np.abs(fine - middle) < 0.5 * np.abs(middle - coarse)).all()
    np.testing.assert_allclose(fine, middle, rtol=0.005)
