"""Quadrilaterals of the transverse section: outline, tiling, joints, shapes, symmetries."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import pi, radians
from typing import Any

import numpy as np
import pytest
import trimesh

from beveloid_geom import Member
from beveloid_geom.arrays import FloatArray, Indices
from beveloid_geom.shapes.section import OUTLINE, Section, section_of, section_size
from beveloid_geom.shapes.sheet import grid_of
from beveloid_geom.shapes.tooth_boundary import cut_sheets
from tests.members import MEMBERS, PINION, SPUR

all_members = pytest.mark.parametrize("member", MEMBERS.values(), ids=MEMBERS)
Outline = dict[str, FloatArray]
CELLS = {"least": (1, 2, 1, 1), "coarse": (1, 4, 6, 4), "fine": (5, 14, 30, 12)}

angles: Any = trimesh.triangles.angles


def outline_of(
    member: Member, bottom: int = 2, fillet: int = 5, flank: int = 8, tip: int = 5, nz: int = 5
) -> Outline:
    cells = {"bottom": bottom, "fillet": fillet, "flank": flank, "tip": tip}
    z = 0.5 * float(member.face_width) * np.linspace(-1.0, 1.0, nz)
    curves = {}
    for name, sheet in cut_sheets(member).items():
        points = grid_of(sheet, np.linspace(0.0, 1.0, cells[name.split()[-1]] + 1), z).points
        curves[name] = points[::-1] if name.startswith("right") else points
    return curves


def least_root(outline: Outline) -> float:
    return float(np.hypot(*outline["left bottom"][0, :, :2].T).min())


def corners(section: Section) -> tuple[FloatArray, FloatArray]:
    """Return scaled Jacobian and angle (rad) at all corners (m, nz, 4) of the quadrilaterals."""
    x = section.points[section.quads][..., :2] @ (1.0, 1.0j)
    ahead, back = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
    turn = np.moveaxis(back / ahead, 1, 2)
    return np.asarray(np.sin(np.angle(turn))), np.asarray(np.angle(turn))


def edges_of(quads: Indices) -> Indices:
    return np.stack((quads, np.roll(quads, -1, axis=1)), axis=-1).reshape(-1, 2)


@pytest.fixture(scope="module")
def pinion() -> tuple[Outline, Section]:
    outline = outline_of(PINION)
    return outline, section_of(outline, 45.0)


def test_the_outline_is_kept(pinion: tuple[Outline, Section]) -> None:
    outline, section = pinion
    for number, name in enumerate(OUTLINE):
        kept = section.points[section.boundary[name]]
        last = -1 if number < len(OUTLINE) - 1 else None  # the last point is the next curve's first
        np.testing.assert_array_equal(kept[:last, :, :2], outline[name][:last, :, :2])
        np.testing.assert_allclose(kept, outline[name], rtol=0.0, atol=1e-10)
    assert (section.points[..., 2] == outline["tip"][0, :, 2]).all()


def test_bore_and_sides(pinion: tuple[Outline, Section]) -> None:
    section = pinion[1]
    first, last, bore = (section.boundary[name] for name in ("first side", "last side", "bore"))
    radius = np.hypot(*np.moveaxis(section.points[bore], -1, 0)[:2])
    np.testing.assert_allclose(radius, 45.0, rtol=1e-14)
    angle = np.unwrap(np.arctan2(*np.moveaxis(section.points[bore], -1, 0)[1::-1]), axis=0)
    assert (np.diff(angle, axis=0) > 0.0).all()
    assert (first[0], last[0]) == (section.boundary["left bottom"][0], section.boundary["right bottom"][-1])
    assert (first[-1], last[-1]) == (bore[0], bore[-1])
    one, other = (section.points[side][..., :2] @ (1.0, 1.0j) for side in (first, last))
    np.testing.assert_allclose(one * np.exp(2.0j * pi / 29.0), other, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(np.angle(one / one[0]), 0.0, atol=1e-14)


@all_members
def test_quadrilaterals_tile_the_section(member: Member) -> None:
    outline = outline_of(member)
    section = section_of(outline, 0.5 * least_root(outline))
    edges = edges_of(section.quads)
    keys = {tuple(edge) for edge in edges.tolist()}
    assert len(keys) == len(edges)
    open_edges = {(a, b) for a, b in keys if (b, a) not in keys}
    around = [edge for nodes in section.boundary.values() for edge in pairwise(nodes.tolist())]
    assert {frozenset(edge) for edge in around} == {frozenset(edge) for edge in open_edges}
    assert len(around) == len(open_edges)
    ahead = dict(open_edges)
    path = [int(section.boundary["bore"][0])]
    while len(path) <= len(ahead) and (len(path) == 1 or path[-1] != path[0]):
        path.append(ahead[path[-1]])
    assert len(path) == len(ahead) + 1
    assert np.array_equal(np.unique(section.quads), np.arange(len(section.points)))
    x = section.points[..., :2] @ (1.0, 1.0j)
    whole = 0.5 * np.sum((x[path[:-1]].conj() * x[path[1:]]).imag, axis=0)
    a, b, c, d = x[section.quads.T]
    parts = 0.5 * ((c - a).conj() * (d - b)).imag
    assert (parts > 0.0).all()
    np.testing.assert_allclose(parts.sum(axis=0), whole, rtol=1e-12)


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
            best = [np.min([angles(points[np.stack(t, -1)]).min(1) for t in cut], axis=0) for cut in cuts]
            assert np.max(best, axis=0).min() > radians(1.0)


def test_two_nodes_of_the_outline_have_three_cells(pinion: tuple[Outline, Section]) -> None:
    section = pinion[1]
    cells = np.bincount(section.quads.ravel())
    edge = np.unique(np.concatenate(list(section.boundary.values())))
    assert (np.delete(cells, edge) == 4).all()
    three = np.flatnonzero(cells[edge] == 3)
    assert len(three) == 2
    for node, name in zip(edge[three], ("left fillet", "right fillet"), strict=True):
        assert node in section.boundary[name]


def test_three_cells_share_the_middle_of_a_fillet(flank: str) -> None:
    section = section_of(outline_of(PINION, 2, 40, 40, 20, nz=3), 45.0)
    fillet = section.boundary[f"{flank} fillet"]
    node = fillet[np.bincount(section.quads.ravel())[fillet] == 3]
    here = (section.quads == node).nonzero()
    angles = corners(section)[1].transpose(0, 2, 1)[here]
    assert angles.shape == (3, 3)
    assert angles.sum(axis=0) == pytest.approx(pi, abs=0.1)
    assert np.abs(angles - pi / 3.0).max() < radians(20.0)


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


@pytest.mark.parametrize("member", [SPUR, replace(PINION, cone_angle=0.0)], ids=["spur", "helical"])
def test_sections_of_a_cylindrical_gear_are_rotated(member: Member) -> None:
    section = section_of(outline_of(member, nz=4), 45.0)
    x = section.points[..., :2] @ (1.0, 1.0j)
    lead = np.tan(member.helix_angle) * 2.0 * np.cos(member.helix_angle) / (6.0 * 29.0)
    turned = x * np.exp(-1.0j * lead * section.points[..., 2])
    assert np.abs(turned - turned[:, :1]).max() < 1e-4


def test_a_rotated_outline_gives_a_rotated_section(pinion: tuple[Outline, Section]) -> None:
    outline, section = pinion
    cos, sin = np.cos(2.0), np.sin(2.0)
    matrix = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    other = section_of({name: curve @ matrix for name, curve in outline.items()}, 45.0)
    np.testing.assert_allclose(other.points, section.points @ matrix, rtol=0.0, atol=1e-9)


def test_a_mirrored_outline_gives_a_mirrored_section(pinion: tuple[Outline, Section]) -> None:
    outline, section = pinion
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


def test_rows_of_the_body_obey_growth_and_aspect() -> None:
    section = section_of(outline_of(SPUR), 20.0)
    side = section.points[section.boundary["first side"], 0]
    height = -np.diff(np.hypot(side[:, 0], side[:, 1]))
    width = 2.0 * pi / 29.0 / (len(section.boundary["bore"]) - 1) * np.hypot(side[1:, 0], side[1:, 1])
    assert (height[1:] / height[:-1]).max() < 1.4 * (1.0 + 1e-9)
    assert (height / width).max() < 1.2 * 8.0
    assert len(height) > 5


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"left fillet": slice(0, None, 5), "right fillet": slice(0, None, 5)},
            "a fillet must have at least 2 cells, got 1",
        ),
        ({"left fillet": slice(1, None), "right fillet": slice(1, None)}, "'left bottom' must end where"),
    ],
)
def test_curves_that_do_not_match_are_rejected(change: dict[str, slice], message: str) -> None:
    outline = outline_of(PINION)
    changed = {name: outline[name][part] for name, part in change.items()}
    with pytest.raises(ValueError, match=message):
        section_of(outline | changed, 45.0)


def test_an_outline_that_intersects_itself_is_rejected() -> None:
    outline = outline_of(SPUR)
    flanks = np.stack((outline["left flank"], outline["right flank"]))
    flanks[:, 4] = flanks[::-1, 4]  # the middles of both flanks exchanged
    with pytest.raises(ValueError, match="cannot be filled with cells"):
        section_of(outline | {"left flank": flanks[0], "right flank": flanks[1]}, 45.0)
