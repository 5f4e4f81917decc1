"""Errors at the mesh: against two lines in space at 40 digits, both conversions, and a pair with a distant
apex.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from beveloid_geom import (
    Design,
    DesignError,
    Errors,
    Member,
    MeshErrors,
    Pair,
    Tool,
    path_of_contact,
    read_design,
)
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.pair.misalignment_at_mesh import at_mesh, from_mesh
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Status
from tests.oracle.table1 import table1
from tests.stability.five_residuals import cases_of
from tests.symmetry import mirrored
from tests.validation.test_intersecting_axes import EQUAL, FILE, LARGE, STRAIGHT

SIZES = np.array((0.3, 2e-3, 2e-3, 0.5, 0.5))
"""Sizes of random errors at the mesh, mm and rad."""


def random_designs(cases: int, crossing_deg: float, seed: int) -> Design:
    """Return random pairs without profile shift whose layout is the closed form of the pair without backlash.

    They are of either hand, with a sum of the helix angles of at most `crossing_deg`."""
    rng = np.random.default_rng(seed)
    cones = np.radians(rng.uniform(1.0, 8.0, (2, cases)))
    helix = np.radians(rng.uniform(5.0, 30.0, (2, cases))) * rng.choice((-1.0, 1.0), cases)
    helix[1] = np.radians(crossing_deg) * rng.uniform(-1.0, 1.0, cases) - helix[0]
    module, teeth = rng.uniform(1.0, 8.0, cases), rng.integers(15, 60, (2, cases))
    cosine = np.cos(cones[0]) * np.cos(cones[1]) * np.cos(helix[0] + helix[1])
    angle = np.arccos(cosine - np.sin(cones[0]) * np.sin(cones[1]))
    radius = 0.5 * teeth * module / np.cos(helix)
    across = radius[0] * np.cos(cones[1]) + radius[1] * np.cos(cones[0])
    offset = across * np.sin(np.abs(helix[0] + helix[1])) / np.sin(angle)
    pinion, gear = (
        Member(Tool(module, pi / 9), teeth[k], helix[k], cones[k], 0.0, 10.0 * module) for k in (0, 1)
    )
    return Design(pinion, gear, Pair(offset, angle))


DESIGNS = {
    "crossed": random_designs(400, 40.0, 1),
    "nearly intersecting": random_designs(300, 5.0, 2),
    "intersecting": random_designs(300, 0.0, 3),
}


def drawn(design: Design, seed: int) -> MeshErrors:
    rng = np.random.default_rng(seed)
    values = rng.uniform(-1.0, 1.0, (5, *design.batch_shape)) * SIZES.reshape(
        5, *(1 for _ in design.batch_shape)
    )
    return MeshErrors(*values)


def differences(first: Any, second: Any) -> float:
    """Return the largest difference, mm and rad; NaN if one value is NaN."""
    return float(
        np.max([np.abs(a - b) for a, b in zip(vars(first).values(), vars(second).values(), strict=True)])
    )


@pytest.mark.parametrize("name", DESIGNS)
def test_both_ways(name: str) -> None:
    design = DESIGNS[name]
    given = drawn(design, 3)
    errors = from_mesh(design, given)
    held = at_mesh(design.with_errors(errors), given.centre_distance, given.out_of_plane)
    assert differences(held, given) < 1e-12
    bare = at_mesh(design.with_errors(errors))
    assert differences(from_mesh(design, bare), errors) < 1e-12
    tilt_kept, distance_kept = (np.asarray(kept) == 0.0 for kept in (bare.out_of_plane, bare.centre_distance))
    assert (tilt_kept ^ distance_kept).all()
    assert tilt_kept.any() == (name != "intersecting")


def rodrigues(axis: Any, angle: Any) -> Any:
    """Return the rotation matrix about a unit vector."""
    x, y, z = axis
    cross = mpmath.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return mpmath.eye(3) + mpmath.sin(angle) * cross + (1 - mpmath.cos(angle)) * cross * cross


def cross(a: Any, b: Any) -> Any:
    return mpmath.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a: Any, b: Any) -> Any:
    return mpmath.fdot(list(a), list(b))


def feet(point: Any, along: Any, sense: float) -> tuple[Any, ...]:
    """Return offset, shaft angle, and axial coordinates of the feet on the z axis and on a line, from
    `point`.
    """
    k1 = mpmath.matrix([0, 0, 1])
    across = cross(along, k1) * sense
    size = mpmath.norm(across)
    # z k1 + e across - t along = point
    solved = mpmath.lu_solve(
        mpmath.matrix([[k1[i], across[i] / size, -along[i]] for i in range(3)]), mpmath.matrix(point)
    )
    return solved[1], mpmath.atan2(size, dot(along, k1)), solved[0], solved[2]


def by_lines(design: Design, given: MeshErrors) -> list[float]:
    """Move the gear axis as a line in space about the pitch point; return offset, angle and both axial
    errors.
    """
    sense = float(design.sense)
    with mpmath.workdps(40):
        pair, num = design.pair, mpmath.mpf
        pitch = mpmath.matrix([num(float(v)) for v in mounting_of(design).pitch_point])
        # The shaft angle as in the library, without rounding.
        angle = num(sense) * num(float(pair.shaft_angle))
        x, k1 = mpmath.matrix([1, 0, 0]), mpmath.matrix([0, 0, 1])
        k2 = mpmath.matrix([0, mpmath.sin(angle), mpmath.cos(angle)])
        foot = x * num(float(pair.offset))
        on_pinion, on_gear = k1 * dot(pitch, k1), foot + k2 * dot(pitch - foot, k2)
        line = (on_gear - on_pinion) / mpmath.norm(on_gear - on_pinion)
        # A right-handed rotation about x moves +z to -y, which decreases the shaft angle.
        first = rodrigues(x, -num(sense) * num(float(given.in_plane)))
        turned = first * k2
        both = rodrigues(cross(turned, x), num(float(given.out_of_plane))) * first
        axis = both * k2
        # Mid-face of the gear, `ahead` of its foot, moves with the body.
        ahead = 100
        middle = pitch + both * (foot + k2 * ahead - pitch) + line * num(float(given.centre_distance))
        middle += axis * num(float(given.gear_axial))
        offset, wide, pinion, gear = feet(middle, axis, sense)
        return [
            float(offset - num(float(pair.offset))),
            float(wide - num(float(pair.shaft_angle))),
            float(num(float(given.pinion_axial)) - pinion),
            float(-gear - ahead),
        ]


SINGLES = {
    "Table 1": table1(),
    "mirrored": mirrored(table1()),
    "24/61": LARGE,
    "37/37": EQUAL,
    "straight": STRAIGHT,
    **{f"{name} {case}": cases_of(design, case) for name, design in DESIGNS.items() for case in range(10)},
}


@pytest.mark.parametrize("name", SINGLES)
def test_lines_in_space(name: str) -> None:
    design = SINGLES[name]
    for seed in range(3):
        given = drawn(design, seed)
        found = [float(value) for value in vars(from_mesh(design, given)).values()]
        scale = max(1.0, *np.abs(mounting_of(design).pitch_distance))
        np.testing.assert_allclose(found, by_lines(design, given), rtol=1e-12, atol=1e-14 * scale)


def test_a_distant_apex() -> None:
    """37/37 teeth: a shaft-angle error about the common perpendicular acts mostly as a shift at the mesh."""
    error = radians(0.02)
    at_the_mesh = from_mesh(EQUAL, MeshErrors(in_plane=error))
    assert (at_the_mesh.pinion_axial, at_the_mesh.gear_axial) == pytest.approx((-8.42, -8.42), abs=0.005)
    places = [
        path_of_contact(EQUAL.with_errors(errors), "right", 3).pinion_z[1]
        for errors in (Errors(), at_the_mesh, Errors(shaft_angle=error))
    ]
    assert np.subtract(places[1:], places[0]) == pytest.approx((-1.37, -10.01), abs=0.005)


AT_MESH = """
[errors]
at = "mesh"
"""


def test_design_files(tmp_path: Path) -> None:
    file = tmp_path / "pair.toml"
    text = FILE.format(module=3.0, teeth=(37, 37), helix=(20.0, -20.0), cone=(0.0, 4.0), face=30.0, shaft=4.0)
    file.write_text(text + AT_MESH + "in_plane_deg = 0.02\nout_of_plane_deg = -0.001\ngear_axial = 0.1")
    given = MeshErrors(in_plane=radians(0.02), out_of_plane=radians(-0.001), gear_axial=0.1)
    at_mesh = replace(EQUAL, errors_at="mesh")
    assert read_design(file) == at_mesh.with_errors(from_mesh(EQUAL, given))
    file.write_text(text + AT_MESH)
    assert read_design(file) == at_mesh
    file.write_text(text + "[errors]\nat = 'perpendicular'\noffset = 0.1")
    assert read_design(file) == EQUAL.with_errors(Errors(offset=0.1))


TO_AXES = (
    'with at = "mesh", the equivalent offset about the common perpendicular must be between -30 and 30 mm'
)
FAULTS = {
    'at = "apex"': 'at must be "perpendicular" or "mesh", got \'apex\': it selects',
    "at = 3": 'at must be "perpendicular" or "mesh", got 3: it selects',
    "at = ['mesh']": 'at must be "perpendicular" or "mesh", got [\'mesh\']: it selects',
    "centre_distance = 0.1": 'centre_distance needs at = "mesh": without it, the keys are offset, ',
    "at = 'mesh'\noffset = 0.1": 'offset needs at = "perpendicular": with at = "mesh", the keys are centre',
    "at = 'mesh'\nin_plane = 0.1": "in_plane is unknown: did you mean in_plane_deg?",
    "at = 'mesh'\nin_plane_deg = '1'": "in_plane_deg must be a number, got '1'",
    "at = 'mesh'\nin_plane_deg = 6": "in_plane_deg must be between -5 and 5 deg, got 6.0",
    "at = 'mesh'\ncentre_distance = 31": "centre_distance must be between -30 and 30 mm (10 modules), got",
    "at = 'mesh'\nin_plane_deg = -5": "in_plane_deg must be at least -4.0 deg, got -5.0: a lower value",
    "at = 'mesh'\nout_of_plane_deg = 3": TO_AXES,
    "at = 'mesh'\ncentre_distance = nan": "centre_distance must be a finite number, got nan",
}


@pytest.mark.parametrize("errors", FAULTS)
def test_invalid_files_give_one_line(errors: str, tmp_path: Path) -> None:
    file = tmp_path / "pair.toml"
    text = FILE.format(module=3.0, teeth=(37, 37), helix=(20.0, -20.0), cone=(0.0, 4.0), face=30.0, shaft=4.0)
    file.write_text(f"{text}[errors]\n{errors}")
    with pytest.raises(DesignError) as caught:
        read_design(file)
    assert len(caught.value.faults) == 1, caught.value.faults
    assert caught.value.faults[0].startswith(f"[errors] {FAULTS[errors]}")


def test_errors_without_an_equivalent_are_nan() -> None:
    nowhere = replace(table1(), pair=Pair(229.0, radians(5.0)))
    assert np.isnan(mounting_of(nowhere).gap)
    assert np.isnan(from_mesh(nowhere, MeshErrors(in_plane=1e-4)).pinion_axial)
    assert np.isnan(at_mesh(nowhere.with_errors(Errors(0.1))).in_plane)
    # Such a tilt of the gear always changes the shaft angle.
    assert np.isnan(at_mesh(EQUAL.with_errors(Errors(offset=3000.0))).out_of_plane)


@pytest.mark.parametrize("tilt", [0.0, 1e-3])
@pytest.mark.parametrize("design", [EQUAL, mirrored(EQUAL)], ids=["37/37", "mirrored"])
def test_axes_rotated_past_parallel_are_nan(design: Design, tilt: float) -> None:
    """The errors are finite up to parallel axes, and NaN beyond, single or in a batch."""
    shaft = float(design.pair.shaft_angle)
    in_plane = np.array((0.01, -0.99 * shaft, -shaft, np.nextafter(-shaft, -1.0), -1.2 * shaft))
    past = np.array((False, False, False, True, True))
    batch = from_mesh(design, MeshErrors(in_plane=in_plane, out_of_plane=tilt))
    for name, values in vars(batch).items():
        assert np.array_equal(np.isnan(values), past), name
    for k, turn in enumerate(in_plane):
        for name, value in vars(from_mesh(design, MeshErrors(in_plane=turn, out_of_plane=tilt))).items():
            np.testing.assert_equal(value, getattr(batch, name)[k])


def test_rotation_past_parallel_of_a_batch_of_layouts() -> None:
    """Each case has its sign; with negative shaft angles, positive errors rotate the axes past parallel. Axes
    that count as parallel may be rotated in both directions."""
    angle = np.radians((4.0, 1.0, -1.0, -1.0, 0.0, 1e-8))
    design = replace(EQUAL, pair=Pair(110.0, angle))
    below, above = (from_mesh(design, MeshErrors(in_plane=radians(turn))) for turn in (-2.0, 2.0))
    assert np.isnan(below.shaft_angle).tolist() == [False, True, False, False, False, False]
    assert np.isnan(above.shaft_angle).tolist() == [False, False, True, True, False, False]


def test_study_of_axes_rotated_past_parallel_has_a_status() -> None:
    """Such cases of a study are undefined; the other cases keep their paths."""
    errors = np.array(((0.0,), (-1.2 * float(EQUAL.pair.shaft_angle),)))
    ends = path_of_contact(mounted(EQUAL, errors, ("in_plane",)), "right", 3).ends
    assert ends.status.tolist() == [Status.SOLVED, Status.UNDEFINED]


@pytest.mark.parametrize(
    "errors",
    [
        MeshErrors(),
        MeshErrors(centre_distance=0.1, pinion_axial=0.2, gear_axial=-0.1),
        MeshErrors(in_plane=1e-4, centre_distance=-0.1),
        MeshErrors(in_plane=-1e-4, gear_axial=0.3),
        MeshErrors(in_plane=2e-5, out_of_plane=-1e-4),
    ],
)
@pytest.mark.parametrize("mounting", [None, 40.0])
def test_parallel_axes_both_ways(errors: MeshErrors, mounting: float | None) -> None:
    """Errors at the mesh of parallel axes are converted to errors about the common perpendicular and back.
    The pitch point is at mid-face; without a tilt the axes keep their line of centres."""
    tool = Tool(3.0, radians(20.0))
    pinion, gear = (Member(tool, 30, side * 0.2, side * 0.05, 0.0, 20.0) for side in (1.0, -1.0))
    design = Design(pinion, gear, Pair(92.0, 0.0, mounting, mounting))
    found = from_mesh(design, errors)
    if errors.out_of_plane == 0.0:
        away = (mounting or 0.0) if errors.in_plane else 0.0
        axial = errors.pinion_axial - away, errors.gear_axial - away
        expected = np.array((errors.centre_distance, errors.in_plane, *axial))
        off = np.abs(np.array([float(value) for value in vars(found).values()]) - expected)
        assert off.max() < (1e-6 if away else 1e-12)
    back = at_mesh(design.with_errors(found), errors.centre_distance, errors.out_of_plane)
    off = np.abs([float(value) - float(vars(errors)[name]) for name, value in vars(back).items()])
    assert off.max() < (1e-7 if errors.out_of_plane else 1e-12)  # distant intersection of the axes: metres
