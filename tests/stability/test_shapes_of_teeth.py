"""Teeth of all shapes and sizes: undercut, pointed, winding, a thousand teeth, very small and large."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    first_contact,
    gear_solid,
    path_certificate,
    sample_flank,
)
from beveloid_geom.findings.layout import remarks_on
from beveloid_geom.gear.flank import tip_thickness
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.gear.rack import reference_radius
from beveloid_geom.gear.undercut import pointed_part, undercut_of
from beveloid_geom.status import FirstStatus, Verdict
from tests.oracle.table1 import table1
from tests.symmetry import scaled

from .answers import (
    FLANKS,
    assert_every_method_agrees,
    changed,
    closed,
    solved_path,
)
from .test_few_teeth import few

PINION, GEAR = table1().members
UNDERCUT = {
    "few teeth": closed(changed(PINION, teeth=8, profile_shift=-0.2, face_width=20.0), GEAR),
    "negative shift": closed(
        changed(PINION, teeth=12, profile_shift=-0.5, face_width=20.0), changed(GEAR, profile_shift=0.9)
    ),
}
POINTED = closed(
    changed(PINION, teeth=18, profile_shift=0.9, cone_angle=radians(10.0), face_width=40.0),
    changed(GEAR, profile_shift=0.0),
)
ONE = closed(few(1, 75.0, 20.0), changed(GEAR, helix_angle=radians(5.0)))
MANY = {
    "gear": closed(PINION, changed(GEAR, teeth=1000)),
    "both": closed(changed(PINION, teeth=1000), changed(GEAR, teeth=1000)),
}


def of_module(module: float) -> Design:
    """Return Table 1 without backlash in another size."""
    return closed(*scaled(table1(), module / 6.0).members)


@pytest.mark.parametrize("design", UNDERCUT.values(), ids=UNDERCUT)
def test_an_undercut_gear_makes_a_solid(design: Design) -> None:
    solid = gear_solid(design.pinion, 0.1)
    edges = np.sort(np.concatenate([solid.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    grid = sample_flank(design.pinion, "right", 0.02)
    assert grid.deviation <= 0.02
    assert np.isfinite(grid.points).all()


def test_a_tooth_pointed_at_the_heel(flank: str) -> None:
    """The flanks intersect below the tip cone: the path ends on the cone or before, not on the ridge."""
    member = POINTED.pinion
    first, last = pointed_part(member)
    assert -20.0 < first < last == 20.0
    assert float(tip_thickness(member, 20.0)) < 0.0 < float(tip_thickness(member, first - 0.01))
    texts = [r for r in remarks_on(POINTED) if "pointed at the heel" in r.text]
    assert [r.level for r in texts] == ["warning"]
    assert texts[0].text.endswith("reduce the profile shift or the addendum")
    with pytest.raises(
        ValueError, match=r"^the tooth is pointed at z = 20 mm, its flanks cross below the tip"
    ):
        gear_solid(member, 0.1)
    path = solved_path(POINTED, flank, 5)
    assert_every_method_agrees(path)
    assert set(np.unique(path_certificate(path).verdict)) <= {v.value for v in Verdict}
    assert np.isfinite(sample_flank(member, flank, 0.02).points).all()


FLAT = {"addendum": 0.1, "dedendum": 0.5, "tip_radius": 0.6}
APART = {
    "offset": table1(errors=Errors(offset=20.0)),
    "axial": table1(errors=Errors(pinion_axial=200.0)),
    "shaft angle": table1(errors=Errors(shaft_angle=radians(3.0))),
    "no depth": replace(
        table1(), pinion=changed(PINION, **FLAT), gear=changed(GEAR, **FLAT, profile_shift=-0.9)
    ),
}


@pytest.mark.parametrize("helix", [70.0, 80.0, -80.0])
@pytest.mark.parametrize("face", [10.0, 40.0, 200.0])
def test_a_winding_tooth_has_constant_thickness(helix: float, face: float, flank: str) -> None:
    """Without a cone, a tooth has the same thickness in every section; the angle about the axis includes full
    turns."""
    member = changed(
        PINION, teeth=1, helix_angle=radians(helix), profile_shift=0.3, cone_angle=0.0, face_width=face
    )
    z = np.linspace(-0.5, 0.5, 41) * face
    thickness = tip_thickness(member, z)
    turn = float(np.abs(np.tan(member.helix_angle)) * face / reference_radius(member))
    np.testing.assert_allclose(thickness, thickness[20], rtol=1e-12 * max(turn, 10.0))
    assert 0.0 < thickness[0] < 2.0 * np.pi * float(tip_radius(member, 0.0))
    assert np.isnan(pointed_part(member)).all()
    assert not undercut_of(member, flank, 9).undercut


def test_undercut_of_a_winding_tooth_is_the_same_in_all_sections() -> None:
    member = changed(
        PINION, teeth=1, helix_angle=radians(50.0), profile_shift=0.3, cone_angle=0.0, face_width=100.0
    )
    found = undercut_of(member, "right", 33)
    assert found.undercut
    assert found.limits == (-50.0, 50.0)
    np.testing.assert_allclose(found.lost, found.lost[16], rtol=1e-6)
    np.testing.assert_allclose(found.neck, found.neck[16], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("design", MANY.values(), ids=MANY)
def test_a_thousand_teeth(design: Design) -> None:
    for flank in FLANKS:
        path = solved_path(design, flank, 5)
        assert_every_method_agrees(path)
        assert path_certificate(path).holds
        assert 1.7 < float(path.ends.contact_ratio) < 2.0
    assert not remarks_on(design)
    solid = gear_solid(design.gear, 0.1, teeth=2)
    assert np.isfinite(solid.points).all()
    assert np.hypot(*solid.points[:, :2].T).max() == pytest.approx(
        float(tip_radius(design.gear, 30.0)), abs=1e-9
    )


@pytest.mark.parametrize("module", [0.05, 0.5, 50.0])
def test_very_small_and_very_large(module: float) -> None:
    """In units of the module, the numbers equal those at module 6; every tolerance scales with the module."""
    design, usual, factor = of_module(module), of_module(6.0), module / 6.0
    for flank in FLANKS:
        path, known = solved_path(design, flank, 5), solved_path(usual, flank, 5)
        np.testing.assert_allclose(path.point, factor * known.point, rtol=0.0, atol=1e-10 * factor)
        np.testing.assert_allclose(path.gear_roll, known.gear_roll, rtol=0.0, atol=1e-11)
        assert float(path.ends.contact_ratio) == pytest.approx(float(known.ends.contact_ratio), abs=1e-11)
        assert_every_method_agrees(path)
        certificate = path_certificate(path)
        assert certificate.holds
        np.testing.assert_allclose(certificate.separation, 0.0, atol=1e-10 * max(1.0, factor))
        first = first_contact(design, flank, path.pinion_roll)
        assert (first.status == FirstStatus.SOLVED).all()
        np.testing.assert_allclose(first.gear_roll, path.gear_roll, rtol=0.0, atol=1e-11)
    grid, same = sample_flank(design.gear, "left", 1e-3 * module), sample_flank(usual.gear, "left", 6e-3)
    np.testing.assert_allclose(grid.points, factor * same.points, rtol=0.0, atol=1e-10 * factor)
    solid, like = gear_solid(design.pinion, 0.02 * module, 1), gear_solid(usual.pinion, 0.12, 1)
    np.testing.assert_array_equal(solid.faces, like.faces)
    np.testing.assert_allclose(solid.points, factor * like.points, rtol=0.0, atol=1e-8 * factor)
    assert not remarks_on(usual)
