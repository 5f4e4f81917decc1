"""Quadrilaterals of the transverse section: outline, tiling, joints, shapes, symmetries."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from typing import Any

import numpy as np
import pytest
import trimesh

from beveloid_geom import Member
from beveloid_geom.arrays import FloatArray
from beveloid_geom.shapes.section import OUTLINE, Section, section_of, section_size
from beveloid_geom.shapes.sheet import grid_of
from beveloid_geom.shapes.tooth_boundary import cut_sheets
from tests.members import MEMBERS, PINION, SPUR

all_members = pytest.mark.parametrize("member", MEMBERS.values(), ids=MEMBERS)
CELLS = {"least": (1, 2, 1, 1), "coarse": (1, 4, 6, 4), "fine": (5, 14, 30, 12)}

angles: Any = trimesh.triangles.angles


def outline_of(
    member: Member, bottom: int = 2, fillet: int = 5, flank: int = 8, tip: int = 5, nz: int = 5
) -> dict[str, FloatArray]:
    cells = {"bottom": bottom, "fillet": fillet, "flank": flank, "tip": tip}
    z = 0.5 * float(member.face_width) * np.linspace(-1.0, 1.0, nz)
    curves = {}
    for name, sheet in cut_sheets(member).items():
        points = grid_of(sheet, np.linspace(0.0, 1.0, cells[name.split()[-1]] + 1), z).points
        curves[name] = points[::-1] if name.startswith("right") else points
    return curves


def least_root(outline: dict[str, FloatArray]) -> float:
    return float(np.hypot(*outline["left bottom"][0, :, :2].T).min())


def corners(section: Section) -> tuple[FloatArray, FloatArray]:
    """Return scaled Jacobian and angle (rad) at all corners (m, nz, 4) of the quadrilaterals."""
    x = section.points[section.quads][..., :2] @ (1.0, 1.0j)
    ahead, back = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
    turn = np.moveaxis(back / ahead, 1, 2)
    return np.asarray(np.sin(np.angle(turn))), np.asarray(np.angle(turn))


@all_members
@pytest.mark.parametrize("cells", CELLS.values(), ids=CELLS)
def test_cells_are_well_shaped(member: Member, cells: tuple[int, int, int, int]) -> None:
    outline = outline_of(member, *cells, nz=3)
    for share in (0.2, 0.9, 0.99) if cells[1] < 10 else (0.7,):
        section = section_of(outline, share * least_root(outline))
        assert corners(section)[0].min() > 0.5
        for station in (0, -1):
            points, (a, b, c, d) = section.points[:, station], section.quads.T
            cuts = [((a, b, c), (a, c, d)), ((a, b, d), (b, c, d))]
            best = [
                np.min([angles(points[np.stack(t, -1)]).min(axis=1) for t in cut], axis=0) for cut in cuts
            ]
            assert np.max(best, axis=0).min() > radians(1.0)


def test_toe_and_heel_are_as_well_shaped_as_the_middle() -> None:
    section = section_of(outline_of(MEMBERS["cone 20"], 2, 20, 50, 10), 70.0)
    least = corners(section)[0].min(axis=(0, 2))
    assert least.min() > 0.9 * least[2]


def harmonic(x: FloatArray, values: FloatArray) -> FloatArray:
    """Return the harmonic function on a grid of points x (rows, columns, 2) with given `values` on its
    boundary, by linear triangles, as the mean of both diagonals."""
    numbers = np.arange(values.size).reshape(values.shape)
    a, b, c, d = numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]
    faces = np.stack([part.ravel() for part in (a, b, c, a, c, d, a, b, d, b, c, d)], -1).reshape(-1, 3)
    p = x.reshape(-1, 2)[faces] @ (1.0, 1.0j)
    sides = np.roll(p, -1, axis=1) - np.roll(p, 1, axis=1)
    area = 0.5 * np.abs((sides[:, 0].conj() * sides[:, 1]).imag)
    stiffness = np.zeros((values.size, values.size))
    for i in range(3):
        for j in range(3):
            part = (sides[:, i].conj() * sides[:, j]).real / area
            np.add.at(stiffness, (faces[:, i], faces[:, j]), part)
    inner = numbers[1:-1, 1:-1].ravel()
    outer = np.setdiff1d(numbers, inner)
    found = values.ravel().copy()
    known = stiffness[np.ix_(inner, outer)] @ found[outer]
    found[inner] = np.linalg.solve(stiffness[np.ix_(inner, inner)], -known)
    return found.reshape(values.shape)


def test_lattice_coordinates_are_harmonic_in_the_tooth() -> None:
    """This is the inverse form of Winslow's equations. Compared with finite elements."""
    section = section_of(outline_of(SPUR, 2, 16, 24, 12, nz=1), 45.0)
    tip, flank = section.boundary["tip"], section.boundary["left flank"]
    across = len(tip)
    nodes = flank[:, None] + np.arange(across)  # rows are numbered through
    np.testing.assert_array_equal(nodes[-1], tip)
    x = section.points[nodes, 0, :2]
    xi = np.broadcast_to(np.linspace(0.0, 1.0, across), nodes.shape)
    found = harmonic(x, xi)
    assert np.abs(found - xi).max() < 5e-4


def test_all_sections_of_a_spur_gear_are_equal() -> None:
    section = section_of(outline_of(SPUR), 45.0)
    assert np.ptp(section.points[..., :2], axis=1).max() < 1e-11


def test_sections_of_a_helical_gear_are_rotated() -> None:
    member = replace(PINION, cone_angle=0.0)
    section = section_of(outline_of(member, nz=4), 45.0)
    x = section.points[..., :2] @ (1.0, 1.0j)
    lead = np.tan(member.helix_angle) * 2.0 * np.cos(member.helix_angle) / (6.0 * 29.0)
    turned = x * np.exp(-1.0j * lead * section.points[..., 2])
    assert np.abs(turned - turned[:, :1]).max() < 1e-4


def test_a_mirrored_outline_gives_a_mirrored_section() -> None:
    outline = outline_of(PINION)
    section = section_of(outline, 45.0)
    mirror = np.array([1.0, -1.0, 1.0])
    swapped = [outline[name][::-1] * mirror for name in reversed(OUTLINE)]
    other = section_of(dict(zip(OUTLINE, swapped, strict=True)), 45.0)
    ours, theirs = section.points * mirror, other.points
    distance = np.abs(ours[:, None] - theirs[None]).max(axis=(2, 3)).min(axis=1)
    assert distance.max() < 1e-9


def test_nodes_move_smoothly_along_the_face() -> None:
    """Fourth differences of the nodes are hardly larger than those of the outline."""
    section = section_of(outline_of(PINION, nz=21), 45.0)
    bend = np.abs(np.diff(section.points, 4, axis=1)).max(axis=(1, 2))
    outer = np.concatenate([section.boundary[name] for name in OUTLINE])
    assert bend.max() < 3.0 * bend[outer].max()


@pytest.mark.parametrize("bore", [15.0, 60.0, 80.0])
def test_size_is_predicted(bore: float) -> None:
    outline = outline_of(PINION)
    section = section_of(outline, bore)
    assert section_size(outline, bore) == (len(section.points), len(section.quads))


def test_a_bottom_land_without_width() -> None:
    outline = outline_of(PINION)
    outline["left fillet"] = np.concatenate((outline["left bottom"], outline["left fillet"][1:]))
    outline["left bottom"] = outline["left bottom"][:1]
    outline["right fillet"] = np.concatenate((outline["right fillet"], outline["right bottom"][1:]))
    outline["right bottom"] = outline["right bottom"][-1:]
    section = section_of(outline, 45.0)
    assert corners(section)[0].min() > 0.5
    assert list(section.boundary["left bottom"]) == [section.boundary["first side"][0]]


def test_curves_that_do_not_meet_are_rejected() -> None:
    outline = outline_of(PINION)
    shorter = {name: outline[name][1:] for name in ("left fillet", "right fillet")}
    with pytest.raises(ValueError, match="'left bottom' must end where"):
        section_of(outline | shorter, 45.0)


def test_an_outline_that_intersects_itself_is_rejected() -> None:
    outline = outline_of(SPUR)
    swapped = outline | {
        "left flank": outline["left flank"].copy(),
        "right flank": outline["right flank"].copy(),
    }
    middle = len(outline["left flank"]) // 2
    swapped["left flank"][middle], swapped["right flank"][middle] = (
        outline["right flank"][middle],
        outline["left flank"][middle],
    )
    with pytest.raises(ValueError, match="cannot be filled with cells"):
        section_of(swapped, 45.0)
