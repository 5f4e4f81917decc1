"""Few teeth, teeth that wind around their axis, nearly parallel axes, and inputs without a solution.

First contacts are compared with dense points of all teeth of the pinion, on both flanks. The rolls at
which a point lies inside a tooth of the gear are blocked; the ends of the open intervals are first
contacts."""

from __future__ import annotations

from collections.abc import Callable
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Member,
    Pair,
    Status,
    contact_ratio,
    first_contact,
    gear_solid,
    mesh_cycle,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.operation.engagement import conjugate_phase, pitch_point_roll
from beveloid_geom.operation.operating_ratio import operating_ratio, operating_ratios
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.report.operation import operation_report
from beveloid_geom.report.result import strict
from beveloid_geom.shapes.proximity.mesh_contact import mesh_contact
from beveloid_geom.shapes.section import section_of, section_size
from beveloid_geom.shapes.sheet import grid_of
from beveloid_geom.shapes.tooth_boundary import cut_sheets
from beveloid_geom.status import FirstStatus, RatioStatus
from beveloid_geom.validation.five_equations import path_of_contact_five_equations
from tests.oracle.table1 import table1
from tests.oracle.tooth import Tooth, seen_from_gear
from tests.shapes.test_solid import assert_closed

from .answers import FLANKS, changed, closed

PINION, GEAR = table1().members
SIGNS = (1.0, -1.0)


def few(
    teeth: int, helix: float, face: float, shift: float = 0.3, cone: float = 0.5, **more: float
) -> Member:
    """Return a pinion with few teeth and a low addendum; angles in deg."""
    angles = {"helix_angle": radians(helix), "cone_angle": radians(cone)}
    return changed(PINION, teeth=teeth, face_width=face, profile_shift=shift, addendum=0.7, **angles, **more)


def pair_of(pinion: Member, gear_helix: float = 5.0) -> Design:
    return closed(pinion, changed(GEAR, helix_angle=radians(gear_helix), addendum=0.7))


def dense_points(tooth: Tooth, rows: int, per_turn: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return radii, angles and z of points of one flank with its fillet."""
    member = tooth.member
    turns = (
        float(np.abs(np.tan(member.helix_angle)) * member.face_width / reference_radius(member)) / 2.0 / np.pi
    )
    z = 0.5 * float(member.face_width) * np.linspace(-1.0, 1.0, 41 + int(per_turn * turns))
    top = tooth.profile(tooth.tip(z), z)
    low = np.linspace(0.02, 0.98, rows // 4)[:, None] + 0.0 * z
    w = np.concatenate((low, 1.0 + np.linspace(0.0, 1.0, rows)[:, None] * (top - 1.0)))
    z = z + 0.0 * w
    return *tooth.polar(w, z), z


def shut(design: Design, roll: float, sign: float, rows: int = 40, per_turn: int = 160) -> FloatArray:
    """Return gear rolls (2, n), rad, at which its right flank meets points of a flank of any pinion tooth and
    its left flank leaves them."""
    radius, theta, z = dense_points(Tooth(design.pinion, sign), rows, per_turn)
    teeth = np.arange(int(design.pinion.teeth))[:, None, None]
    turned = theta + roll + 2.0 * np.pi * teeth / design.pinion.teeth
    x, y, z = seen_from_gear(design, radius, turned, z)
    reach, right, left = np.hypot(x, y), *(Tooth(design.gear, sign) for sign in SIGNS)
    inside = (np.abs(z) <= 0.5 * design.gear.face_width) & (reach <= right.tip(z))
    at, reach, z = np.arctan2(y, x)[inside], reach[inside], z[inside]
    meets, leaves = (at - flank.angle_at(reach, z) for flank in (right, left))
    assert np.isfinite(meets).all()
    assert np.isfinite(leaves).all()
    return np.stack((meets, meets + np.remainder(leaves - meets, 2.0 * np.pi)))


def open_ends(design: Design, roll: float) -> tuple[float, float, float]:
    """Return the first contacts of right and left flanks at a roll of the pinion, by points: the gear rolls
    (rad, up to multiples of the pitch) to which the gear can turn from its middle position; and the pitch."""
    pitch = 2.0 * np.pi / float(design.gear.teeth)
    parts = [shut(design, roll, sign) for sign in SIGNS]
    low, high = np.concatenate(parts, axis=1)
    high = high - low
    low = np.remainder(low, pitch)
    low, high = np.concatenate((low - pitch, low)), np.concatenate((low - pitch + high, low + high))
    order = np.argsort(low)
    low, high = low[order], np.maximum.accumulate(high[order])
    widths = np.where(low[1:] >= 0.0, low[1:] - high[:-1], -1.0)
    widest = int(np.argmax(widths))
    assert widths[widest] > 0.0
    middle = 0.5 * (low[widest + 1] + high[widest])
    right = middle + np.remainder(parts[0][0] - middle, pitch).min(initial=np.inf)
    left = middle - np.remainder(middle - parts[1][1], pitch).min(initial=np.inf)
    return float(right), float(left), pitch


def assert_first_contacts(design: Design, roll: float, within: float = 0.01) -> None:
    """Check the first contacts against points; they may be earlier by the error between points (mm)."""
    right, left, pitch = open_ends(design, roll)
    lever = 0.5 * float(GEAR.tool.normal_module) * design.gear.teeth * np.cos(GEAR.tool.normal_pressure_angle)
    found = [first_contact(design, flank, roll) for flank in FLANKS]
    for first, end, sign in zip(found, (right, left), SIGNS, strict=True):
        assert first.status[0] == FirstStatus.SOLVED
        assert np.isfinite(first.gear_roll[0])
        late = sign * (end - float(first.gear_roll[0]))
        late = np.remainder(late + 0.5 * pitch, pitch) - 0.5 * pitch
        assert -1e-9 < lever * late < within
    if np.isfinite(conjugate_phase(design, "right")):
        # Not wrong by pitches: the flanks of a tooth are a pitch minus the clearance apart.
        between = float(found[1].gear_roll[0] - found[0].gear_roll[0]) - (pitch - right + left)
        assert lever * abs(np.remainder(between + np.pi, 2.0 * np.pi) - np.pi) < 2.0 * within


CASES = [
    (1, 75.0, 20.0, 0.3, 0.5, 5.0),
    (1, 70.0, 50.0, 0.8, 2.0, 15.0),
    (1, 80.0, 100.0, 0.6, 0.0, -10.0),
    (2, 60.0, 50.0, 0.8, 0.0, 5.0),
    (2, 75.0, 100.0, 0.3, 0.5, 5.0),
    (3, 75.0, 50.0, 0.8, 2.0, 15.0),
    (4, 70.0, 20.0, 0.3, 0.5, 5.0),
    (5, 80.0, 100.0, 0.6, 0.0, -10.0),
    (8, 60.0, 100.0, 0.3, 0.5, 5.0),
    (8, 20.0, 20.0, 0.8, 2.0, 15.0),
]


@pytest.mark.parametrize(("teeth", "helix", "face", "shift", "cone", "gear_helix"), CASES)
def test_first_contacts_of_few_teeth_agree_with_points(
    teeth: int, helix: float, face: float, shift: float, cone: float, gear_helix: float
) -> None:
    design = pair_of(few(teeth, helix, face, shift, cone), gear_helix).with_errors(Errors(offset=0.3))
    roll = float(np.random.default_rng(teeth).uniform(-np.pi, np.pi))
    assert_first_contacts(design, roll)
    # A turn of the pinion equals this number of pitches of the gear.
    turns = first_contact(design, "right", roll + 2.0 * np.pi * np.arange(-1, 2))
    steps = np.diff(turns.gear_roll) * float(design.gear.teeth) / (2.0 * np.pi)
    np.testing.assert_allclose(steps, -teeth, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(np.diff(turns.pair), -teeth)


@pytest.mark.parametrize(("teeth", "axial"), [(1, 0.0), (2, -20.0), (2, 0.0)])
def test_few_teeth_on_the_gear(teeth: int, axial: float) -> None:
    """First contacts agree with points for a gear of one or two teeth, whose clearances reach beyond half a
    turn of the gear."""
    gear = few(teeth, 70.0, 30.0, 0.6, 0.0)
    design = closed(changed(GEAR, helix_angle=radians(5.0), addendum=0.7), gear)
    assert_first_contacts(design.with_errors(Errors(offset=0.3, gear_axial=axial)), 0.03, 0.03)


@pytest.mark.parametrize("face", [5.0, 20.0])
def test_a_single_thread_is_certified(face: float, flank: str) -> None:
    """The path of a pinion with one tooth is certified: its other turns touch other teeth of the gear and do
    not overlap them."""
    design = closed(few(1, 75.0, face), changed(GEAR, helix_angle=radians(5.0)))
    proof = path_certificate(path_of_contact(design, flank, 5))
    assert proof.holds
    np.testing.assert_allclose(proof.separation, 0.0, atol=1e-9)


def wound(teeth: int, helix: float) -> Design:
    """Return a pinion with teeth of full height."""
    return closed(changed(PINION, teeth=teeth, helix_angle=radians(helix)), GEAR)


def counted_ratio(design: Design, flank: str, rolls: int = 400) -> float:
    """Return the mean, over a pitch, of the number of tooth pairs with a position of their path of contact at
    a roll."""
    pitch = 2.0 * np.pi / float(design.pinion.teeth)
    on_path = path_of_contact(design, flank, 401).pinion_roll
    roll = pitch * (np.arange(rolls) + 0.5) / rolls
    shifted = roll + pitch * np.arange(-9, 10)[:, None]
    return float(((shifted >= on_path.min()) & (shifted <= on_path.max())).sum(axis=0).mean())


@pytest.mark.parametrize(
    ("teeth", "helix", "flank"), [(1, 80.0, "right"), (2, 75.0, "left"), (3, 70.0, "right")]
)
def test_teeth_that_wind_operate_with_the_ratio_of_eq_16(teeth: int, helix: float, flank: str) -> None:
    """The contact ratio in operation of teeth that wind around their axis is that of Eq. 16. Earlier, other
    turns of the teeth were counted if a tooth pair had no contact, which gave -2.16."""
    design = wound(teeth, helix)
    ratio = float(operating_ratio(design, flank))
    assert ratio == pytest.approx(float(contact_ratio(design, flank)), abs=1e-8)
    assert ratio == pytest.approx(counted_ratio(design, flank), abs=1.0 / 200)
    cycle = mesh_cycle(design, flank, 2)
    assert float(cycle.peak_to_peak) < 1e-13
    assert cycle.edge_share == 0.0
    assert cycle.hand_over.sum() == 1


@pytest.mark.parametrize(("teeth", "helix"), [(1, 80.0), (3, 80.0)])
def test_a_requested_tooth_pair_belongs_to_this_turn(teeth: int, helix: float) -> None:
    design = wound(teeth, helix)
    pitch = 2.0 * np.pi / teeth
    roll = float(pitch_point_roll(design, "right")) + pitch * np.linspace(-4.0, 4.0, 49)
    alone = first_contact(design, "right", roll, pairs=[0])
    assert (alone.pair == 0).all()
    on_path = path_of_contact(design, "right", 101).pinion_roll
    touches = np.abs(alone.transmission_error) < 1e-12
    np.testing.assert_array_equal(touches, (roll >= on_path.min()) & (roll <= on_path.max()))


def test_ratios_within_a_thickness_of_winding_teeth() -> None:
    """Ratios within a film agree with counts over even rolls. For a film as thick as the distance to the next
    turn there is no ratio, and the status states this."""
    design, pitch, film = wound(1, 80.0), 2.0 * np.pi, 0.05
    # The gear's base pitch is the way to the next turn; a quarter of it may be overlap.
    turn = np.pi * float(GEAR.tool.normal_module) * np.cos(float(GEAR.tool.normal_pressure_angle))
    found = operating_ratios(design, "right", (0.0, film, turn))
    assert found.status.tolist() == [RatioStatus.KNOWN, RatioStatus.KNOWN, RatioStatus.TOO_THICK]
    assert np.isnan(found.ratio[2])
    roll = float(pitch_point_roll(design, "right")) + pitch * np.linspace(-1.5, 1.5, 91)
    error = [first_contact(design, "right", roll, pairs=pairs).transmission_error for pairs in (None, [0])]
    lever = turn * float(GEAR.teeth) / (2.0 * np.pi)
    counted = (lever * np.abs(error[1] - error[0]) <= film).sum() / 30
    assert found.ratio[1] == pytest.approx(counted, abs=1.1 / 30)
    assert found.ratio[1] > found.ratio[0] + 0.1


def test_a_report_has_the_reason_for_an_unknown_ratio() -> None:
    design = closed(few(1, 75.0, 20.0), changed(GEAR, helix_angle=radians(5.0)))
    report = operation_report("wound", design, "left", 2, 1, 18.0)
    why = "the film reaches beyond the tooth pairs considered: choose a thinner film"
    lines = " ".join(report.summary().split())
    assert f"{report.operating:.6f} in operation, not known ({why}) with clearances up to 18000 um" in lines
    data = strict(report.data())
    assert data["operating_contact_ratio"] == pytest.approx(float(report.eq16), abs=1e-8)
    assert data["operating_contact_ratio_within_film"] is None
    assert data["operating_contact_ratio_within_film_reason"] == why


def parallel(shaft_angle_deg: float) -> Design:
    """Return cylindrical gears with opposite helix angles and their mid-faces on the common perpendicular."""
    pinion = changed(PINION, cone_angle=0.0)
    gear = changed(GEAR, cone_angle=0.0, helix_angle=-float(PINION.helix_angle))
    shifts = float(pinion.tool.normal_module) * (pinion.profile_shift + gear.profile_shift)
    offset = float(reference_radius(pinion) + reference_radius(gear)) + shifts + 0.3
    return Design(pinion, gear, Pair(offset, radians(shaft_angle_deg), 0.0, 0.0))


@pytest.mark.parametrize("shaft_angle", [0.1, 0.01, 1e-7])
def test_teeth_touch_far_from_their_pitch_point(shaft_angle: float) -> None:
    design = parallel(shaft_angle)
    assert np.abs(mounting_of(design).pitch_point).max() > 1e5
    assert_first_contacts(design, 0.03)
    roll = 0.03 + 2.0 * np.pi / float(PINION.teeth) * np.arange(3)
    first = first_contact(design, "left", roll)
    moved = first.gear_roll + PINION.teeth / GEAR.teeth * roll
    np.testing.assert_allclose(moved, moved[0], rtol=0.0, atol=1e-12)


def test_a_displaced_single_thread_is_correct_or_has_a_status() -> None:
    """First contacts of a thread that is displaced along its axis are correct where the thread is in phase
    with the gear; between these positions they are NaN, with a status."""
    plain = pair_of(few(1, 75.0, 20.0, 0.6, 0.0))
    moved = np.linspace(-30.0, 30.0, 13)
    design = plain.with_errors(Errors(offset=0.3, pinion_axial=moved))
    first = first_contact(design, "right", np.full((13, 1), 0.3))
    assert np.isin(first.status, (FirstStatus.SOLVED, FirstStatus.OUT_OF_STEP)).all()
    solved = (first.status == FirstStatus.SOLVED)[:, 0]
    assert np.isnan(first.gear_roll[~solved]).all()
    assert 4 < solved.sum() < 13
    for k in np.flatnonzero(solved)[::2]:
        right, _, pitch = open_ends(design.with_errors(Errors(0.3, 0.0, float(moved[k]))), 0.3)
        late = np.remainder(right - first.gear_roll[k, 0] + 0.5 * pitch, pitch) - 0.5 * pitch
        assert -1e-9 < late < 1e-3 * pitch


UNSOLVABLE = {
    "spur": Design(
        changed(PINION, helix_angle=0.0, cone_angle=0.0),
        changed(GEAR, helix_angle=0.0, cone_angle=0.0),
        Pair(240.0, 0.2),
    ),
    "parallel": Design(PINION, GEAR, Pair(247.0, 0.0)),
}


@pytest.mark.parametrize("design", UNSOLVABLE.values(), ids=UNSOLVABLE)
def test_a_design_without_a_solution_has_a_reason(design: Design) -> None:
    path = path_of_contact_five_equations(design, "right", 5)
    assert path.ends.status == Status.UNDEFINED
    assert path.l1.size == 0
    with pytest.raises(ValueError, match=r"^the pair cannot be positioned: .*$"):
        mesh_contact(design, "right", 0.1, pinion_roll=0.0, gear_roll=0.0)
    first = first_contact(design, "right", [0.0, 0.1])
    assert (first.status == FirstStatus.UNDEFINED).all()
    assert np.isnan(first.gear_roll).all()


def test_a_single_tooth_makes_no_solid() -> None:
    """A gear with one tooth makes no solid, because its section surrounds the axis. Rows of zero height must
    not lead to an endless loop."""
    member = few(1, 60.0, 6.0, 0.8, 0.0)
    with pytest.raises(ValueError, match=r"^teeth must be at least 2 for a solid, got 1: the section .*$"):
        gear_solid(member, 0.1)
    z = np.linspace(-3.0, 3.0, 3)
    outline = {}
    for name, sheet in cut_sheets(member).items():
        points = grid_of(sheet, np.linspace(0.0, 1.0, 9), z).points
        outline[name] = points[::-1] if name.startswith("right") else points
    sizes: tuple[Callable[..., object], ...] = (section_size, section_of)
    for size in sizes:
        with pytest.raises(ValueError, match=r"^an outline must be that of one tooth and span at most"):
            size(outline, 1.0)


@pytest.mark.parametrize(("helix", "face"), [(60.0, 20.0), (80.0, 2.0), (80.0, 60.0), (-80.0, 60.0)])
def test_two_teeth_make_a_closed_solid(helix: float, face: float) -> None:
    """A gear with two teeth makes a closed solid. Its teeth wind by up to a turn and a half along the face;
    half a turn is a pitch."""
    solid = gear_solid(few(2, helix, face, 0.5, 0.0), 0.1)
    assert_closed(solid, 1)
    x, y, _ = solid.points.T
    turned = np.lexsort(np.round(np.stack((-x, -y, solid.points[:, 2])), 6))
    same = np.lexsort(np.round(np.stack((x, y, solid.points[:, 2])), 6))
    np.testing.assert_allclose(
        solid.points[turned] * (-1.0, -1.0, 1.0), solid.points[same], rtol=0.0, atol=2e-6
    )
