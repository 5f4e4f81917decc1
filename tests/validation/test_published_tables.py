"""Published tables of spur, helical and beveloid gears, within half a unit of their last printed digit.

Nothing in a table is fitted: the inputs are those printed.
"""

from __future__ import annotations

from dataclasses import replace
from math import acos, atan, atan2, cos, degrees, hypot, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from beveloid_geom import Design, Member, Pair, Tool, contact_lines, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.hertz import contact_modulus, hertz_ellipse
from beveloid_geom.gear.flank import base_cylinder, flank_patch, half_thickness_angle, tip_thickness
from beveloid_geom.gear.flank_limits import root_parameter, tip_parameter, tip_radius
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.status import Limit

ALPHA = radians(20.0)


def made(
    module: float,
    teeth: int,
    helix: float,
    shift: float,
    tip_diameter: float | None = None,
    alpha: float = ALPHA,
) -> Member:
    """Return a cylindrical gear; without a tip diameter its addendum is one module."""
    member = Member(Tool(module, alpha), teeth, helix, 0.0, shift, 200.0)
    if tip_diameter is None:
        return member
    addendum = (0.5 * tip_diameter - float(reference_radius(member))) / module - shift
    return replace(member, tool=replace(member.tool, addendum=addendum))


def parallel(pinion: Member, gear: Member, centre: float) -> dict[str, FloatArray]:
    """Return results for gears on parallel axes at a centre distance.

    The results are the `transverse` working pressure angle (rad), the `backlash` along the normal (mm), the
    working pitch `diameter` (2) (mm), the diameters (2) `active` at which the tips of the mates end the path
    (mm), and the transverse contact `ratio`."""
    design = Design(pinion, gear, Pair(centre, 0.0))
    mounting, lines = mounting_of(design), contact_lines(path_of_contact(design, points=3))
    assert {Limit.GEAR_TIP, Limit.PINION_TIP} <= set(lines.limit.ravel().tolist())
    base = np.array([float(base_cylinder(member, "right").radius) for member in design.members])
    return {
        "transverse": np.arccos(base / mounting.working_radius)[0],
        "backlash": mounting.normal_backlash,
        "diameter": 2.0 * mounting.working_radius,
        "active": 2.0 * np.array((lines.pinion_r.min(), lines.gear_r.min())),
        "ratio": lines.transverse_ratio,
    }


def on_flank(member: Member, value: str, wanted: float) -> tuple[FloatArray, FloatArray]:
    """Return the point of the right flank at mid-face that has the radius `wanted`, or whose normal has the
    angle `wanted` to the middle of the tooth, and its normal."""

    def patch(l: float) -> tuple[FloatArray, FloatArray]:
        found = flank_patch(member, "right", l, z=0.0)
        return found.point, found.normal

    def missing(l: float) -> float:
        point, normal = patch(l)
        vector = point if value == "radius" else normal
        length, angle = hypot(vector[0], vector[1]), atan2(vector[1], vector[0])
        return (length if value == "radius" else angle) - wanted

    low, high = float(root_parameter(member, "right")), float(tip_parameter(member, "right", 0.0))
    return patch(brentq(missing, low, high, xtol=1e-14))


def test_profile_shifted_spur_gears() -> None:
    """Profile Shifted External Spur Gears, table 'Profile Shifted Spur Gear', items 9, 10, 13, 14, 18, 20
    (bolsover.com/utilitiesforalibre/profile-shifted-external-spur-gears.html; the example of the KHK
    and SDP/SI handbooks)."""
    pinion, gear = made(3.0, 12, 0.0, 0.6, 44.840), made(3.0, 24, 0.0, 0.36, 79.400)
    found = parallel(pinion, gear, 56.5)
    working = float(found["transverse"])
    assert degrees(working) == pytest.approx(26.0888, abs=5.1e-5)
    assert tan(working) - working == pytest.approx(0.034317, abs=5.1e-7)
    assert found["diameter"] == pytest.approx([37.667, 75.333], abs=5.1e-4)
    assert float(found["ratio"]) == pytest.approx(1.202, abs=5.1e-4)
    for member, base in ((pinion, 33.8289), (gear, 67.6579)):
        assert 2.0 * float(base_cylinder(member, "right").radius) == pytest.approx(base, abs=5.1e-5)
    # The sum of the shifts is printed as 0.960; without backlash it is 0.96006.
    assert abs(float(found["backlash"])) < 2.0 * 3.0 * sin(ALPHA) * 5e-4


def test_profile_shifted_helical_gears() -> None:
    """UtilitiesForAlibre, UnitTests/Gear/StandardHelicalGearCalculatorTests.cs and
    UnitTests/Involute/Calculator/ProfileShiftedExternalHelicalGearCalculatorTest.cs
    (github.com/bolsover/UtilitiesForAlibre, 1308ff3; the example of the KHK and SDP/SI handbooks)."""
    beta = radians(30.0)
    pinion, gear = made(3.0, 12, beta, 0.09809, 48.15390), made(3.0, 60, -beta, 0.0, 213.84224)
    found = parallel(pinion, gear, 125.0)
    assert degrees(float(found["transverse"])) == pytest.approx(23.112632, abs=1e-6)
    assert abs(float(found["backlash"])) < 2.0 * 3.0 * sin(ALPHA) * 5e-6
    for member, pitch, base in ((pinion, 41.56921, 38.32229), (gear, 207.8460, 191.6114)):
        cylinder = base_cylinder(member, "right")
        assert 2.0 * float(reference_radius(member)) == pytest.approx(pitch, abs=1e-4)
        assert 2.0 * float(cylinder.radius) == pytest.approx(base, abs=1e-4)
        transverse = degrees(acos(float(cylinder.radius) / float(reference_radius(member))))
        assert transverse == pytest.approx(22.79587, abs=1e-5)
    assert float(found["ratio"]) == pytest.approx(1.2939, abs=5.1e-5)


def test_backlash_by_iso_21771() -> None:
    """Gear Generating Profile Shift Calculations, 'According to ISO 21771:2007', Eqs. 62 and 63
    (scribd.com/document/376176518): sums of the shifts without backlash, and for 0.03 mm."""
    beta = acos(3.5 * 61 / (2 * 114.3447280708))
    assert degrees(beta) == pytest.approx(21.0, abs=1e-9)
    for total, backlash in ((0.651877131252, 0.0), (0.639346541, 0.03)):
        pinion, gear = made(3.5, 31, beta, 0.291), made(3.5, 30, -beta, total - 0.291)
        found = parallel(pinion, gear, 116.5)
        assert degrees(float(found["transverse"])) == pytest.approx(23.8707609654, abs=1e-6)
        assert float(found["backlash"]) == pytest.approx(backlash, abs=1e-7)


EXAMPLES = {
    # module, a_n, teeth, helix, shifts, tip diameters; centre distance, working transverse pressure
    # angle, pitch diameters in operation, active root diameters, transverse contact ratio
    "A": (
        (8.0, 20.0, (17, 103), 15.8, (0.1452220936512015, 0.0), (159.66, 872.35)),
        (500.0, 21.066099804698517, 141.66666666666666, 858.3333333333334),
        (132.920685546483, 845.2252368254899, 1.549090096889056),
    ),
    "C": (
        (3.0, 22.5, (25, 40), -30.0, (0.3, -0.1), (94.4, 144.0)),
        (113.17655661808965, 26.182356800441667, 87.0588897062228, 139.2942235299565),
        (83.12303952174517, 133.50574122587557, 1.2529391073475025),
    ),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_iso_21771_in_decimal_arithmetic(name: str) -> None:
    """References of the package gearcore for DIN ISO 21771:2014, typed from the standard and evaluated at
    45 digits, cases A and C of its test of pair geometry; A is ISO/TR 6336-30, Annex A, example 1. (In B
    the tips are cut down, and with them the depth to which a flank here is active: its path is shorter.)"""
    (module, alpha, teeth, helix, shift, tips), (centre, *working), active = EXAMPLES[name]
    pinion, gear = (
        made(module, teeth[k], radians((helix, -helix)[k]), shift[k], tips[k], radians(alpha)) for k in (0, 1)
    )
    found = parallel(pinion, gear, centre)
    assert abs(float(found["backlash"])) < 1e-8 * centre
    values = [degrees(found["transverse"]), *found["diameter"], *found["active"], found["ratio"]]
    assert values == pytest.approx([*working, *active], rel=1e-7)


def test_iso_6336_example_1() -> None:
    """ISO/TR 6336-30:2017, example 1, as printed by KISSsoft (KSISO_6336.m, github.com/gfsReboucas/
    Drivetrain, 2d65971): zone factor, contact ratio factor and virtual numbers of teeth by ISO 6336-1
    and -2, which follow from base helix, pressure angles and contact ratio."""
    beta = radians(15.8)
    pinion, gear = made(8.0, 17, beta, 0.145, 159.66), made(8.0, 103, -beta, 0.0, 872.35)
    found, cylinder = parallel(pinion, gear, 500.0), base_cylinder(pinion, "right")
    across, working = cos(float(cylinder.helix_angle)), float(found["transverse"])
    transverse = float(cylinder.radius) / float(reference_radius(pinion))
    zone = sqrt(2 * across / tan(working)) / transverse
    assert zone == pytest.approx(2.39533, abs=5.1e-6)
    assert 1.0 / sqrt(float(found["ratio"])) == pytest.approx(0.803, abs=5.1e-4)
    assert 17 / (across**2 * cos(beta)) == pytest.approx(18.905, abs=5.1e-4)
    assert 103 / (across**2 * cos(beta)) == pytest.approx(114.543, abs=5.1e-4)


def test_gear_as_measured() -> None:
    """MESYS, Calculation of geometry for helical gear, the gear first shown (mesys.ag/calc/
    helicalgear.fcgi?lang=en): base diameter, thickness at the tip, span over two teeth, over balls."""
    gear, ball = made(1.0, 20, 0.0, 0.0), 1.7
    assert 2.0 * float(base_cylinder(gear, "left").radius) == pytest.approx(18.7939, abs=5.1e-5)
    assert 2.0 * float(tip_radius(gear, 0.0)) == pytest.approx(22.0, abs=1e-12)
    assert float(tip_thickness(gear, 0.0)) == pytest.approx(0.6949, abs=5.1e-5)
    # The middle of two teeth is at half a pitch, and the faces of the caliper are parallel to it.
    point, normal = on_flank(gear, "normal", pi / 2 - pi / 20)
    assert 2.0 * float(point @ normal) == pytest.approx(4.7083, abs=5.1e-5)
    assert 2.0 * float(np.hypot(*point[:2])) == pytest.approx(19.3746, abs=5.1e-5)

    def off(radius: float) -> float:
        point, normal = on_flank(gear, "radius", radius)
        centre = point + 0.5 * ball * normal
        return atan2(centre[1], centre[0]) - pi / 20

    radius = float(brentq(off, 9.5, 10.5, xtol=1e-13))
    point, normal = on_flank(gear, "radius", radius)
    centre = float(np.linalg.norm(point + 0.5 * ball * normal))
    assert 2.0 * radius == pytest.approx(19.9594, abs=5.1e-5)
    assert 2.0 * centre + ball == pytest.approx(22.2941, abs=5.1e-5)


def test_chordal_thickness() -> None:
    """SDP/SI, Elements of Metric Gear Technology, Table 10-1 (T-81; fdocuments.us/document/
    elements-of-metric-gear-technology-i-sdpsi-governing-equations-become-simple.html)."""
    gear = made(10.0, 12, 0.0, 0.3)
    point, _ = on_flank(gear, "radius", 60.0)
    half = atan2(point[1], point[0])
    assert degrees(half) == pytest.approx(8.54270, abs=5.1e-6)
    assert 2.0 * 60.0 * half == pytest.approx(17.8918, abs=5.1e-5)
    assert 2.0 * point[1] == pytest.approx(17.8256, abs=5.1e-5)
    assert float(tip_radius(gear, 0.0)) - point[0] == pytest.approx(13.6657, abs=5.1e-5)


@pytest.mark.parametrize(
    ("module", "alpha_deg", "teeth", "helix_deg", "shift", "thickness"),
    [
        (5.0, 20.0, 16, 25.0, 0.2, 8.5819),
        # given in the transverse plane: m_t 4, a_t 20 deg, x_t 0.3
        (
            4.0 * cos(radians(22.5)),
            degrees(atan(tan(ALPHA) * cos(radians(22.5)))),
            20,
            22.5,
            0.3 / cos(radians(22.5)),
            6.6119,
        ),
    ],
    ids=["Table 10-3", "Table 10-4"],
)
def test_thickness_of_helical_teeth(
    module: float, alpha_deg: float, teeth: int, helix_deg: float, shift: float, thickness: float
) -> None:
    """SDP/SI, Elements of Metric Gear Technology, Tables 10-3 and 10-4 (T-82; ro.scribd.com/document/
    244615472): normal thickness s_n. The chords in the tables are those of the virtual spur gear, not true
    chords."""
    tool = Tool(module, radians(alpha_deg))
    gear = Member(tool, teeth, radians(helix_deg), 0.0, shift, 40.0)
    pitch = float(reference_radius(gear))
    point, _ = on_flank(gear, "radius", pitch)
    angle = 2.0 * atan2(point[1], point[0])
    assert pitch * angle * cos(radians(helix_deg)) == pytest.approx(thickness, abs=5.1e-5)
    both = sum(
        float(half_thickness_angle(gear, flank, tip_parameter(gear, flank, 0.0), 0.0))
        for flank in ("right", "left")
    )
    assert both * float(tip_radius(gear, 0.0)) == pytest.approx(float(tip_thickness(gear, 0.0)), rel=1e-12)


BEVELOIDS = (
    # cone and helix angles, deg, teeth; module, mm, force, N, crossing of the generators and pressure angle,
    # deg, modulus, MPa, Poisson's ratio; greatest pressure, MPa, and half the length of the ellipse, mm
    (
        ((2.672796806918542, -11.439727635719741, 26), (2.3975483194762806, 5.47111917134702, 49)),
        (2.135643981569113, 91888.15525375084, -8.899258338008508, 22.857119490527204),
        (218317.5172269292, 0.3048673148872094),
        (3051.4165413646087, 19.158941229983395),
    ),
    (
        ((3.8666952057811548, -13.170787441329999, 29), (2.316366058058045, 10.911685639623073, 87)),
        (4.857247326785755, 21562.367250220545, -8.979121190265976, 21.151016889600655),
        (218590.23464925747, 0.21233333843574562),
        (887.3706874807607, 18.02177687888238),
    ),
    (
        ((2.3737958789779126, 0.6238526433870462, 19), (2.382663044208197, 20.367948853010375, 76)),
        (7.309348456114342, 82676.74069673526, -4.17445943569247, 19.832902577440393),
        (202810.3743279972, 0.3494074122520452),
        (1038.9279837884344, 54.54921087754621),
    ),
    (
        ((0.1351930477262903, 12.426126369309465, 22), (5.324424490397449, 14.192325947414645, 49)),
        (6.768213984943216, 10951.982228774843, 9.613871023213779, 19.582557241134676),
        (218888.5787736629, 0.3920530619039567),
        (878.6104858345055, 12.006709843659072),
    ),
    (
        ((0.13968627305530873, 25.14878823318655, 24), (3.7666469913523613, -14.989829411386273, 89)),
        (7.132855142958758, 19793.636746680535, 9.977629178960928, 18.155638040847325),
        (209886.30536573802, 0.39332951336253663),
        (787.4641442253852, 17.59373247943484),
    ),
)


@pytest.mark.parametrize("row", BEVELOIDS, ids=["row 1", "row 2", "row 3", "row 45", "row 20"])
def test_pressures_of_marine_beveloid_gears(row: tuple[tuple[Any, ...], ...]) -> None:
    """Data of "Geometric design and hard-constrained optimization of marine beveloid gearboxes with coupled
    intersecting and crossed shafts based on physics-guided deep neural network" (github.com/pggady/
    Marine-Beveloid-PG-DNN, afaee8e, pinn_training_data.csv): right flanks of both members at the pitch
    cylinders, each a straight generator and one curvature, that of its base cylinder. The source has half the
    modulus of two equal bodies, E / (4 (1 - nu^2)): its pressures are too small by a factor of 2^(2/3)."""
    members, (module, force, crossing, alpha), material, printed = row
    curvatures = []
    for cone, helix, teeth in members:
        tool = Tool(module, radians(alpha))
        member = Member(tool, teeth, radians(helix), radians(cone), 0.0, 180.0)
        cylinder = base_cylinder(member, "right")
        across = sqrt(float(reference_radius(member)) ** 2 - float(cylinder.radius) ** 2)
        curvatures.append(cos(float(cylinder.helix_angle)) / across)
    total, product = sum(curvatures), curvatures[0] * curvatures[1] * sin(radians(crossing)) ** 2
    greatest = 0.5 * (total + sqrt(total**2 - 4.0 * product))
    curvature = (product / greatest, greatest)
    source = hertz_ellipse(curvature, force, 0.5 * contact_modulus(*material))
    assert [float(source.pressure), float(source.semi_axes[0])] == pytest.approx(printed, rel=1e-11)
    found = hertz_ellipse(curvature, force, contact_modulus(*material))
    assert float(found.pressure) == pytest.approx(2.0 ** (2.0 / 3.0) * printed[0], rel=1e-11)
