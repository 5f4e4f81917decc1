"""Positions of the gears for files: rolls of the pinion, and origins near the gears."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import first_contact
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export.positions import frames_at_roll, near_origin
from tests.cli import running
from tests.oracle.table1 import table1

FAR = """
tool = { normal_module = 0.1, normal_pressure_angle_deg = 20.0 }
pair = { offset = 0.0, shaft_angle_deg = 0.02 }
[pinion]
teeth = 25
helix_angle_deg = 25.0
cone_angle_deg = 0.01
profile_shift = 0.0
face_width = 0.8
[gear]
teeth = 31
helix_angle_deg = -25.0
cone_angle_deg = 0.01
profile_shift = 0.0
face_width = 0.8
"""
"""Axes that intersect at 0.02 deg: the gears are 8.9 m from the origin of S_f."""


@pytest.mark.parametrize("roll", [0.05, 0.3])
def test_frames_at_a_roll_are_those_of_the_first_contact(roll: float) -> None:
    design = table1()
    position = meshing_pair(design)
    turn = roll - position.roll[0]
    gear_turn = float(first_contact(design, "right", [roll]).gear_roll[0]) - position.roll[1]
    for before, after, angle in zip(
        position.frames, frames_at_roll(design, position, roll), (turn, gear_turn), strict=True
    ):
        relative = before[0].T @ after[0]
        assert np.arctan2(relative[1, 0], relative[0, 0]) == pytest.approx(angle, abs=1e-12)
        np.testing.assert_allclose(after[1], before[1], rtol=0, atol=1e-12)
    assert frames_at_roll(design, position, None) is position.frames


@pytest.mark.parametrize("suffix", [".stl", ".glb", ".step", ".vtp"])
def test_mesh_writes_the_pair_at_a_roll(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str) -> None:
    """`mesh --part pair` writes different files for different values of --roll-deg; in .step files the pinion
    turns by their difference."""
    asked = []

    def step(
        design: object, path: Path, frames: tuple[tuple[np.ndarray, np.ndarray], ...], _: object
    ) -> None:
        asked.append(frames[0][0])
        path.write_text("")

    monkeypatch.setattr("beveloid_geom.export.step.write_step_pair", step)
    files = []
    for k, roll in enumerate(("3", "9")):
        path = tmp_path / f"{k}{suffix}"
        result = running.run(
            "mesh", "--part", "pair", "--roll-deg", roll, "--out", path,
            *(["--tolerance", "0.2"] if suffix != ".step" else []),
        )  # fmt: skip
        assert (result.exit_code, result.stderr) == (0, "")
        files.append(path.read_bytes())
    if suffix == ".step":
        relative = asked[0].T @ asked[1]
        assert np.degrees(np.arctan2(relative[1, 0], relative[0, 0])) == pytest.approx(6.0)
    else:
        assert files[0] != files[1]


def test_stl_far_from_the_origin_has_an_origin_near_the_gears(tmp_path: Path) -> None:
    """The triangles are as exact as those of a .ply file in double precision, except for the origin."""
    import meshio

    (tmp_path / "far.toml").write_text(FAR)
    points = {}
    for suffix in (".stl", ".ply"):
        path = tmp_path / f"pair{suffix}"
        result = running.run(
            "mesh", tmp_path / "far.toml", "--part", "pair", "--tolerance", "0.01", "--out", path
        )
        assert (result.exit_code, result.stderr) == (0, "")
        assert ("; origin at (0, 1, 8851) mm in S_f" in result.stdout) == (suffix == ".stl")
        read = meshio.read(path)
        points[suffix] = read.points[read.cells_dict["triangle"]]
    assert b"origin at (0, 1, 8851) mm" in (tmp_path / "pair.stl").read_bytes()[:80]
    np.testing.assert_allclose(points[".stl"] + (0.0, 1.0, 8851.0), points[".ply"], rtol=0, atol=3e-7)


def test_usual_pairs_keep_the_origin_of_the_frame() -> None:
    design = table1()
    assert not near_origin(design, meshing_pair(design)).any()
