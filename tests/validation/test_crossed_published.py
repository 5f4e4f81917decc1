"""Published numbers of crossed involute helical gears.

Source: the golden files and the documentation of the open program gearcalc (github.com/git-akai/gearcalc). At
a shaft angle equal to the sum of the helix angles, gears with profile shift have no backlash at the distance
(d_1 + d_2)/2 + (x_1 + x_2) m_n, and the normal backlash grows with the distance by 2 sin(alpha_n). Their
lines of action do not meet, so that the paths of right and left flanks are displaced along the face; each
flank pair meshes exactly."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, degrees, radians, sin

import numpy as np
import pytest

from beveloid_geom import Design, Member, Pair, Tool, mesh_cycle, mounted_backlash, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.findings.advice import design_remarks, layout_advice
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.pair.zero_backlash import layout_deviation

ALPHA = radians(20.0)


@dataclass(frozen=True)
class Crossed:
    """Crossed helical gears by their published numbers: mm, deg."""

    module: float
    teeth: tuple[int, int]
    helix_deg: tuple[float, float]
    shift: tuple[float, float] = (0.0, 0.0)

    @property
    def offset(self) -> float:
        """Distance without backlash by this formula, mm."""
        sizes = zip(self.teeth, self.helix_deg, strict=True)
        reference = 0.5 * self.module * sum(n / cos(radians(helix)) for n, helix in sizes)
        return reference + sum(self.shift) * self.module

    def design(self, more: float, face: float = 200.0) -> Design:
        """Return the pair at a distance larger by the given amount, with mid-faces on the common
        perpendicular."""
        tool = Tool(self.module, ALPHA)
        members = zip(self.teeth, self.helix_deg, self.shift, strict=True)
        pinion, gear = (Member(tool, n, radians(beta), 0.0, x, face) for n, beta, x in members)
        return Design(pinion, gear, Pair(self.offset + more, radians(sum(self.helix_deg)), 0.0, 0.0))


SHIFTED = (
    Crossed(3.0, (15, 24), (20.0, 30.0), (0.4, 0.2)),
    Crossed(2.0, (20, 40), (15.0, 25.0), (0.3, 0.1)),
    Crossed(2.5, (17, 43), (8.0, 7.0), (0.5, 0.5)),
)
ROWS = (
    (Crossed(1.0, (17, 23), (18.0, 72.0)), 46.1522, 1.739531377),
    (Crossed(1.0, (17, 23), (36.0, 54.0)), 30.0715, 1.751996715),
    (Crossed(1.0, (17, 23), (54.0, 36.0)), 28.6758, 1.765340595),
    (Crossed(1.0, (17, 23), (72.0, 18.0)), 39.5984, 1.77290751),
)
"""Pair, printed reference distance (mm), contact ratio at 0.02 mm more."""


@pytest.mark.parametrize("pair", SHIFTED)
def test_backlash_of_shifted_crossed_gears_is_linear_in_the_distance(pair: Crossed) -> None:
    """The backlash by the closed form of the mounting and by first contacts of all teeth grows with the
    distance by 2 sin(alpha_n)."""
    for more in (0.0, 0.02, 0.1):
        design = pair.design(more)
        expected = 0.68404 * more
        assert float(mounting_of(design).normal_backlash) == pytest.approx(expected, abs=1e-7)
        assert float(mounting_of(design).normal_backlash) == pytest.approx(2.0 * sin(ALPHA) * more, abs=1e-12)
        assert float(mounted_backlash(design).normal) == pytest.approx(2.0 * sin(ALPHA) * more, abs=1e-9)


@pytest.mark.parametrize(("pair", "reference", "ratio"), ROWS)
def test_contact_ratios_of_crossed_gears(pair: Crossed, reference: float, ratio: float, flank: str) -> None:
    assert pair.offset == pytest.approx(reference, abs=5.1e-5)
    found = path_of_contact(pair.design(0.02, 60.0), flank, 2).ends.contact_ratio
    assert float(found) == pytest.approx(ratio, abs=5.1e-10)


def apart_along_the_axes(design: Design) -> FloatArray:
    """Return the distances (2,), mm, along both axes between the nearest points of the paths, which are
    straight lines."""
    right, left = (path_of_contact(design, flank, 2).point for flank in ("right", "left"))
    steps = np.stack((right[1] - right[0], left[0] - left[1]), axis=-1)
    along = np.linalg.lstsq(steps, left[0] - right[0], rcond=None)[0]
    between = left[0] - right[0] - steps @ along
    angle = float(design.pair.shaft_angle)
    return np.asarray(np.abs(np.array([(0.0, 0.0, 1.0), (0.0, sin(angle), cos(angle))]) @ between))


@pytest.mark.parametrize("pair", SHIFTED[:2])
def test_displaced_paths_are_a_note_and_mesh_exactly(pair: Crossed) -> None:
    """There is no warning and no advice; the sizes in the note are those of the paths on the faces."""
    design = pair.design(0.02, 30.0)
    assert layout_deviation(design).gap > 5.0
    found = design_remarks(design)
    assert {remark.level for remark in found} == {"note"}
    assert layout_advice(design) == ()
    (text,) = [remark.text for remark in found if "displaced along the face" in remark.text]
    sizes = [float(text.split(f" mm on the {name}")[0].split()[-1]) for name in ("pinion", "gear")]
    np.testing.assert_allclose(apart_along_the_axes(design), sizes, rtol=1e-3)
    for flank in ("right", "left"):
        cycle = mesh_cycle(design, flank)
        assert degrees(float(cycle.peak_to_peak)) * 3600.0 < 1e-6
        assert float(cycle.edge_share) == 0.0


def test_a_path_that_leaves_the_face_is_a_warning() -> None:
    pair = SHIFTED[0]
    design = pair.design(0.02, 12.0)
    warnings = [remark.text for remark in design_remarks(design) if remark.level == "warning"]
    assert any("displaced along the face" in text and "a path leaves the face" in text for text in warnings)
    assert any("the contact reaches the" in text for text in warnings)
    assert layout_advice(design)
