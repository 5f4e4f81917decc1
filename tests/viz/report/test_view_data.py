"""Data of the 3D view: the teeth are closed, touch, and do not overlap."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from functools import cache
from math import cos, pi, radians
from typing import Any, cast

import numpy as np
import pytest
import pyvista as pv
from numpy.polynomial.chebyshev import chebval
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from beveloid_geom import Design, Errors, first_contact, gear_solid, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.shapes.surface_mesh import gear_mesh
from beveloid_viz.report.view_data import carried_phase, view_data
from tests.oracle.table1 import table1
from tests.symmetry import mirrored

TABLE = table1()
DESIGNS = {
    "table 1": TABLE,
    "modified": table1((0.001, -0.001)),
    "misaligned": table1((-0.0005, -0.0005), Errors(offset=0.2, shaft_angle=radians(0.01), pinion_axial=0.3)),
    "left hand": mirrored(TABLE),
}
TOLERANCE = 0.012
"""Default tolerance of `view_data` for a module of 6 mm, mm."""


@cache
def view_of(name: str) -> dict[str, Any]:
    return view_data(DESIGNS[name])


every_design = pytest.mark.parametrize("name", DESIGNS)


def unpacked(value: dict[str, Any]) -> NDArray[Any]:
    """Return the values (n,) of a packed array, decoded as by the page."""
    kind = np.dtype(value["type"]).newbyteorder("<")
    return np.frombuffer(base64.b64decode(value["data"]), dtype=kind)


def of_path(view: dict[str, Any], flank: str, name: str) -> FloatArray:
    values = cast("FloatArray", unpacked(view["flanks"][flank]["path"][name]))
    return values if name in ("roll", "phase") else values.reshape(-1, 3)


def gear_roll(view: dict[str, Any], phase: FloatArray, roll: FloatArray) -> FloatArray:
    teeth = [member["teeth"] for member in view["members"]]
    return np.asarray(phase - teeth[0] / teeth[1] * roll)


def placed(member: dict[str, Any], points: FloatArray, roll: FloatArray) -> FloatArray:
    """Return points of a member in S_f, each at its roll, placed as by the page."""
    cos, sin = np.cos(roll), np.sin(roll)
    x, y, z = points.T
    spun = np.stack((cos * x - sin * y, sin * x + cos * y, z), axis=-1)
    return np.asarray(spun @ np.reshape(member["rotation"], (3, 3)).T + member["origin"])


def cycle_at(view: dict[str, Any], flank: str, steps: int = 120) -> tuple[FloatArray, FloatArray]:
    """Return rolls and phases of one mesh cycle, evaluated as by the page."""
    cycle = view["flanks"][flank]["cycle"]
    into = cycle["pitch"] * np.linspace(0.0, 1.0, steps + 1)
    piece, x = piece_at(cycle, into)
    series = unpacked(cycle["phase"]).reshape(len(cycle["edges"]), -1)
    return into + float(cycle["start"]), chebval(x, series[piece].T, tensor=False)


def piece_at(cycle: dict[str, Any], into: FloatArray) -> tuple[NDArray[np.int_], FloatArray]:
    """Return segment and position from -1 to 1 in it, for rolls after the start of a cycle."""
    ends = unpacked(cycle["ends"])
    piece = np.minimum(np.searchsorted(ends, into), ends.size - 1)
    low = np.append(0.0, ends)[piece]
    return piece, 2.0 * (into - low) / (ends[piece] - low) - 1.0


@every_design
def test_tooth_pair_k_is_tooth_k_of_the_pinion_on_tooth_minus_k_of_the_gear(name: str, flank: str) -> None:
    view = view_of(name)
    pitch = [2.0 * pi / member["teeth"] for member in view["members"]]
    path_roll, point = of_path(view, flank, "roll"), of_path(view, flank, "point")
    path = path_of_contact(DESIGNS[name], flank, 65)
    np.testing.assert_allclose(point, path.point, atol=1e-12)
    for pair in (-3, 0, 1, 2):
        roll = path_roll - pair * pitch[0]
        rolls = roll, gear_roll(view, of_path(view, flank, "phase"), roll)
        for member, own, step, tooth in zip(view["members"], rolls, pitch, (pair, -pair), strict=True):
            points = of_path(view, flank, member["name"])
            np.testing.assert_allclose(placed(member, points, own + step * tooth), point, atol=1e-9)


def tooth_of(member: dict[str, Any]) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """Return points, normals and faces of the stored tooth."""
    points, normals, faces = (
        unpacked(member["tooth"][key]).reshape(-1, 3) for key in ("points", "normals", "faces")
    )
    return points.astype(float), normals.astype(float), faces.astype(np.int64)


@pytest.mark.parametrize("number", [0, 1])
def test_turned_teeth_are_the_gear(number: int) -> None:
    member = DESIGNS["modified"].members[number]
    stored = view_of("modified")["members"][number]
    points, _, faces = tooth_of(stored)
    gear = gear_mesh(member, TOLERANCE)
    # Without end faces, whose triangles depend on the number of teeth.
    tooth_faces = faces[: len(faces) - stored["tooth"]["end_faces"]]
    gear_faces = gear.faces[~gear.is_of("toe", "heel")]
    angles = 2.0 * pi / member.teeth * np.arange(int(member.teeth))
    tooth = points[np.unique(tooth_faces)]
    every = np.concatenate([placed({"rotation": np.eye(3), "origin": 0.0}, tooth, a) for a in angles])
    expected = gear.points[np.unique(gear_faces)]
    assert len(tooth_faces) * int(member.teeth) == len(gear_faces)
    for one, other in ((every, expected), (expected, every)):
        np.testing.assert_allclose(cKDTree(one).query(other)[0], 0.0, atol=2e-5)  # single precision


@pytest.mark.parametrize("number", [0, 1])
def test_faces_point_outwards_and_end_faces_are_last(number: int) -> None:
    """The page draws the inside of faces as the cut surface of sections."""
    data = view_of("table 1")["members"][number]
    points, normals, faces = tooth_of(data)
    a, b, c = (points[faces[:, k]] for k in range(3))
    out = np.cross(b - a, c - a)
    assert (np.einsum("ij,ij->i", out, normals[faces[:, 0]]) > 0.0).all()
    flat = np.abs(np.ptp(points[faces, 2], axis=1)) < 1e-9
    assert flat[-data["tooth"]["end_faces"] :].all()
    assert not flat[: -data["tooth"]["end_faces"]].any()


@cache
def gear_body(name: str) -> Any:
    solid = gear_solid(DESIGNS[name].gear, TOLERANCE)
    return pv.PolyData(solid.points, np.column_stack((np.full(len(solid.faces), 3), solid.faces)).ravel())


def clearance(view: dict[str, Any], name: str, roll: float, gear: float) -> float:
    """Return the smallest signed distance, mm, of the pinion teeth in mesh from the solid gear."""
    pinion, other = view["members"]
    tooth, step = tooth_of(pinion)[0], 2.0 * pi / pinion["teeth"]
    nearest = round(-(roll + np.arctan2(tooth[:, 1].mean(), tooth[:, 0].mean())) / step)
    teeth = [placed(pinion, tooth, np.array(roll + (nearest + k) * step)) for k in range(-2, 4)]
    seen = (np.concatenate(teeth) - other["origin"]) @ np.reshape(other["rotation"], (3, 3))
    seen = seen @ np.array([[np.cos(gear), -np.sin(gear), 0], [np.sin(gear), np.cos(gear), 0], [0, 0, 1]])
    tips = max(other["tip_radius"]) + 0.5
    near = seen[(np.hypot(seen[:, 0], seen[:, 1]) < tips) & (np.abs(seen[:, 2]) < other["half_width"])]
    return float(pv.PolyData(near).compute_implicit_distance(gear_body(name))["implicit_distance"].min())


@pytest.mark.parametrize("name", ["table 1", "modified", "left hand"])
def test_teeth_touch_without_overlap(name: str, flank: str) -> None:
    """The teeth do not overlap. If the gear is rotated by 0.1 mm towards the pinion, they do."""
    view, lever = view_of(name), view_of(name)["flanks"][flank]["lever"]
    roll, phase = cycle_at(view, flank)
    push = (1.0 if flank == "right" else -1.0) * 0.1 / lever
    for i in (7, 47, 88):
        gear = float(gear_roll(view, phase[i], roll[i]))
        assert clearance(view, name, roll[i], gear) > -2.0 * TOLERANCE
        assert clearance(view, name, roll[i], gear + push) < -0.05


@every_design
def test_gear_position_follows_first_contact(name: str, flank: str) -> None:
    """The position of the gear is that of the first contact. It differs from the position by the path only in
    segments with edge contact."""
    view, design = view_of(name), DESIGNS[name]
    roll, phase = cycle_at(view, flank)
    cycle = view["flanks"][flank]["cycle"]
    piece, _ = piece_at(cycle, roll - cycle["start"])
    edges = np.array([edge is not None for edge in cycle["edges"]])[piece]
    assert cycle["by"] == "first contact"
    assert phase[0] == pytest.approx(phase[-1], abs=1e-12)
    ahead = phase - carried_phase(path_of_contact(design, flank, 65), roll)
    ahead *= 1.0 if flank == "left" else -1.0
    first = first_contact(design, flank, roll)
    wanted = first.gear_roll + design.pinion.teeth / design.gear.teeth * roll
    np.testing.assert_allclose(phase, wanted, atol=1e-13)
    np.testing.assert_allclose(ahead[~edges], 0.0, atol=1e-7)  # linear between the points
    assert (ahead[edges] > -1e-7).all()
    assert edges.any() == (name == "modified")
    assert (ahead.max() > 5e-6) == (name == "modified")


def test_edges_and_their_coordinates() -> None:
    """The stored points of edge contacts equal the first contacts at twenty rolls in every segment with edge
    contact."""
    cycle = view_of("modified")["flanks"]["right"]["cycle"]
    edges = [(k, edge) for k, edge in enumerate(cycle["edges"]) if edge]
    assert {edge["edge"] for _, edge in edges} == {"gear tip"}
    ends, x = np.append(0.0, unpacked(cycle["ends"])), np.linspace(-0.99, 0.99, 20)
    for k, edge in edges:
        roll = cycle["start"] + 0.5 * (ends[k] + ends[k + 1] + (ends[k + 1] - ends[k]) * x)
        point = chebval(x, unpacked(edge["point"]).reshape(3, -1).T).T
        wanted = first_contact(DESIGNS["modified"], "right", roll).point
        np.testing.assert_allclose(point, wanted, atol=1e-9)


ODD = {
    "undercut": replace(TABLE, pinion=replace(TABLE.pinion, teeth=9, profile_shift=-0.3)),
    "no normal": replace(TABLE, pair=replace(TABLE.pair, shaft_angle=radians(60.0))),
    "off the flanks": TABLE.with_errors(Errors(offset=12.0)),
    "pointed": replace(TABLE, gear=replace(TABLE.gear, profile_shift=3.0)),
    "no fillet": TABLE.with_parabola(pinion=0.01),
    "one tooth": replace(TABLE, pinion=replace(TABLE.pinion, teeth=1)),
}


@pytest.mark.parametrize("design", ODD.values(), ids=ODD)
def test_odd_designs_are_shown_with_words(design: Design) -> None:
    view = view_data(design)
    assert json.loads(json.dumps(view, allow_nan=False)) == view
    for member in view["members"]:
        assert (member["tooth"] is None) == bool(member["note"])
    for flank in view["flanks"].values():
        assert (flank["path"] is None) == bool(flank["note"])
        assert np.isfinite(unpacked(flank["cycle"]["phase"])).all()
    assert any(part["note"] for part in (*view["members"], *view["flanks"].values()))


def test_an_unmodified_pair_has_the_lever_of_its_base_helix() -> None:
    """The lever is the base radius times the cosine of the base helix angle, m_n N cos(alpha)/2 on both
    flanks."""
    for name in ("table 1", "left hand"):
        for flank in view_of(name)["flanks"].values():
            assert flank["lever"] == pytest.approx(0.5 * 6.0 * 45.0 * cos(radians(20.0)), rel=1e-12)


@pytest.mark.parametrize("number", [0, 1])
def test_corners_are_root_and_tip_at_the_toe_then_at_the_heel(number: int) -> None:
    member = view_of("table 1")["members"][number]
    for corners in member["tooth"]["corners"].values():
        radius, z = np.hypot(*np.transpose(corners)[:2]), np.transpose(corners)[2]
        np.testing.assert_allclose(z, np.repeat((-1.0, 1.0), 2) * member["half_width"], atol=1e-9)
        np.testing.assert_allclose(radius[1::2], member["tip_radius"], atol=1e-6)
        assert (radius[::2] < radius[1::2] - 6.0).all()
        assert radius[3] > radius[1]  # the tooth grows towards +z


def test_initial_position_of_the_view() -> None:
    """The view begins in the middle of the path of the right flanks. Its centre is the pitch point, or a
    point within the pinion if the pitch point is far away."""
    view, none = view_of("table 1"), view_data(ODD["no normal"])
    assert view["roll"] == view["flanks"]["right"]["middle"]
    assert none["roll"] == none["flanks"]["right"]["middle"]
    np.testing.assert_array_equal(view["mesh_point"], mounting_of(TABLE).pitch_point)
    far = view_data(replace(TABLE, pair=replace(TABLE.pair, shaft_angle=radians(14.84))), 0.1)
    assert np.hypot(*far["mesh_point"][:2]) <= max(far["members"][0]["tip_radius"]) + 1e-9


def test_gear_position_without_first_contact() -> None:
    """If first contacts are not known, here without fillets, the position follows from the path, and no edges
    are named. With unmodified flanks, gear roll + N1/N2 pinion roll is constant."""
    unmodified = replace(TABLE, pinion=replace(TABLE.pinion, tool=replace(TABLE.pinion.tool, tip_radius=0.9)))
    for design in (ODD["no fillet"], unmodified):
        view = view_data(design)
        for flank in view["flanks"].values():
            assert flank["cycle"]["by"] == "path"
            assert not any(flank["cycle"]["edges"])
        phase = cycle_at(view, "right")[1]
        assert np.isfinite(phase).all()
        assert (np.ptp(phase) < 1e-12) == (design is unmodified)


def test_the_view_stays_small_and_takes_single_designs() -> None:
    assert len(json.dumps(view_of("table 1"))) < 200_000
    assert len(json.dumps(view_data(TABLE, 0.1))) < 110_000
    with pytest.raises(ValueError, match="a single design"):
        view_data(TABLE.with_errors(Errors(offset=np.zeros(3))))
