"""Fig. 6, magnified deviations and their factor, and the figure that compares modifications."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beveloid_geom import Design, MeshCycle, Modification, builtin_design, measuring_grid
from beveloid_geom.arrays import FloatArray
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.workshop.measured import deviations_of
from beveloid_viz.figures.paper import fig_06_modification as fig
from beveloid_viz.figures.results import modifications
from beveloid_viz.rendering.layout import of_size

from ...symmetry import mirrored, scaled
from ..pages import page_of, words


def polar(points: FloatArray) -> FloatArray:
    """Return radius and angle from the vertical (2, n) of points (2, n)."""
    return np.stack((np.hypot(*points), np.arctan2(-points[0], points[1])))


def test_the_section_is_magnified_by_the_factor_stated() -> None:
    """With a factor of 1, the displaced points of the involute lie on the profile. The drawn deviation is
    larger by the factor and perpendicular to the involute."""
    data = fig.compute(builtin_design())
    assert data.factor == 5.0
    for a, section in data.sections.items():
        np.testing.assert_array_equal(section.magnified(0.0), section.base)
        # Turned about the axis, an involute moves by one distance along all of its normals.
        (radius, angle), (own, place) = (polar(points) for points in (section.base, section.magnified(1.0)))
        turn = polar(np.stack((section.across, section.up)))[1] - angle
        inner = (own > radius[0]) & (own < radius[-1])
        assert inner.mean() > 0.9
        off = own * (place - turn - np.interp(own, radius, angle))
        assert np.abs(off[inner]).max() < 2e-4, a
        step, tangent = section.magnified(data.factor) - section.base, np.gradient(section.base, axis=1)
        along = (step * tangent).sum(axis=0) / np.hypot(*tangent)
        assert np.abs(along).max() < 0.02 * max(np.hypot(*step).max(), 1e-9), a
        # The normal leans out of the section by the base helix angle: 1 mm along it is a little more there.
        way = np.hypot(*section.per_mm)
        np.testing.assert_allclose(np.hypot(*step), 5.0 * np.abs(section.deviation) * way, atol=1e-12)
        assert 1.0 <= way.min() <= way.max() < 1.1


@pytest.mark.parametrize(("times", "factor"), [(1.0, 5.0), (0.1, 50.0), (0.0, 1.0)])
def test_the_factor_is_round_and_said(times: float, factor: float) -> None:
    data = fig.compute(builtin_design())
    sections = {a: replace(one, deviation=times * one.deviation) for a, one in data.sections.items()}
    page = page_of(fig.draw, replace(data, sections=sections))
    assert f"deviation \u00d7 {factor:g}" in " ".join(axes.get_title(loc="left") for axes in page.axes)
    assert f"thick lines with {factor:g} times their deviation" in words(page)


def test_the_figure_is_the_same_at_any_module() -> None:
    usual, small = (fig.compute(scaled(builtin_design(), times)) for times in (1.0, 0.05))
    assert (usual.coefficient, small.coefficient) == (0.01, 0.2)
    for sign, section in usual.sections.items():
        np.testing.assert_allclose(0.05 * section.deviation, small.sections[sign].deviation, atol=1e-9)


def test_a_left_flank_is_drawn_as_the_right_flank_of_the_mirrored_pair() -> None:
    left = fig.compute(builtin_design(), "left")
    right = fig.compute(mirrored(builtin_design()), "right")
    assert left.ends == ("heel", "toe")
    for sign, section in right.sections.items():
        for name in ("across", "up", "deviation", "base", "per_mm"):
            mine, other = getattr(left.sections[sign], name), getattr(section, name)
            np.testing.assert_allclose(mine, other, atol=1e-9)


def test_a_flank_that_ends_below_the_tip_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fig, "COEFFICIENT_PER_MM", 0.03)
    data = fig.compute(builtin_design())
    missing = sorted(set(fig.LOOKS) - set(data.members))
    assert missing
    for sign in missing:
        assert f"The {fig.LOOKS[sign].name} flank ends below the tip" in words(page_of(fig.draw, data))


# The comparison of modifications


def crowned(design: Design) -> Design:
    return replace(design, pinion=design.pinion.modified(Modification(helix_crowning_um=10.0)))


def cycle_of(case: modifications.ModificationCase) -> MeshCycle:
    assert case.operation is not None
    return case.operation.cycle


def swing(case: modifications.ModificationCase) -> float:
    return ARCSEC * float(cycle_of(case).peak_to_peak)


@pytest.mark.slow
def test_crowning_against_parabolas() -> None:
    """The numbers of Table 1 were computed by brute force with separate code: transmission errors of 0,
    1.81 and 0.13 arcsec, and with crowning a shift of the path by 3.8 mm under a shaft-angle error of
    0.01 deg, 0.1 pitches after l1 = 0. A design with a modification of its own is compared without it."""
    plain, bent, round_ = modifications.compute(builtin_design()).cases
    np.testing.assert_allclose([swing(case) for case in (plain, bent, round_)], (0.0, 1.81, 0.13), atol=0.01)
    assert float(cycle_of(bent).edge_share) == pytest.approx(0.18, abs=0.01)
    assert float(cycle_of(round_).edge_share) == 0.0
    np.testing.assert_allclose(round_.shifts[1, [0, -1]], (3.9, -3.9), atol=0.3)
    own_plain, own = modifications.compute(crowned(builtin_design())).cases
    assert swing(own) == swing(round_)
    assert own_plain.path.design == builtin_design()


@pytest.mark.slow
def test_measured_flanks_are_compared_with_nominal_ones() -> None:
    """Flanks measured on a grid without border have the result of the flanks that were measured."""
    design = builtin_design()
    points = measuring_grid(crowned(design).pinion, 9, 17, 0.0).point
    found = deviations_of(measuring_grid(design.pinion, 9, 17, 0.0), points).on_flanks
    given = Modification(deviations=found)
    comparison = modifications.compute(replace(design, pinion=design.pinion.modified(given)))
    assert comparison.title.startswith("Measured")
    nominal, measured = comparison.cases
    assert [case.name for case in comparison.cases] == ["nominal", "measured"]
    assert nominal.path.design == design
    assert swing(measured) == pytest.approx(0.13, abs=0.01)
    np.testing.assert_allclose(measured.shifts[1, [0, -1]], (3.9, -3.9), atol=0.3)
    page = modifications.RECIPES["modifications"].drawn(comparison, of_size((1600, 1200))).page
    assert [axes.get_title("left")[:3] for axes in page.axes] == ["(a)", "(b)", "(c)", "(d)", "(e)"]
