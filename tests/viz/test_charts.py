"""Charts that figures, page and film share: what they draw is the result's, the same in every place."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from beveloid_geom import builtin_design, tolerance_study
from beveloid_geom.analysis.tolerance import USUAL
from beveloid_geom.contact.ellipse import MARKING_SEPARATION
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport, operation_report
from beveloid_geom.report.pattern import pattern_report
from beveloid_viz.figures.results import pattern as fig_pattern
from beveloid_viz.parts import charts

from ..symmetry import scaled

MODIFIED = builtin_design().with_parabola(0.001, -0.001)


@pytest.fixture(scope="module")
def report() -> OperationReport:
    return operation_report("", MODIFIED, "right", 61, 10, MARKING_SEPARATION)


def test_the_figure_of_the_pattern_has_the_commands_points() -> None:
    """At any module, not only at that of Table 1."""
    small = scaled(MODIFIED, 0.5 / 6.0)
    found = pattern_report("", small, "left", MARKING_SEPARATION).pattern
    layers = fig_pattern.compute_pattern(small).columns[2].layers
    assert layers is not None
    for layer, side in zip(layers, (found.pinion, found.gear), strict=True):
        np.testing.assert_array_equal(layer.l, side.l)
        np.testing.assert_array_equal(layer.values, 1e3 * side.least)


def test_the_error_repeats_and_its_dots_are_hand_overs(report: OperationReport) -> None:
    axes = Figure().add_subplot()
    charts.error_over_rolls(axes, report, 3)
    curve, edges, dots = axes.lines
    share, error = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
    assert (share[0], share[-1]) == (0.0, 3.0)
    np.testing.assert_allclose(error[:61], ARCSEC * (report.first.transmission_error - report.cycle.mean))
    np.testing.assert_array_equal(error[:61], error[122:])
    known = np.isfinite(np.asarray(edges.get_ydata(), dtype=float))
    np.testing.assert_array_equal(known[:61], report.first.limit[:, 0] >= 0)
    assert len(np.asarray(dots.get_xdata())) == 3 * np.count_nonzero(report.cycle.hand_over)


def test_amplitudes_are_the_cycles(report: OperationReport) -> None:
    axes = Figure().add_subplot()
    charts.amplitudes(axes, report)
    heights = [patch.get_height() for patch in axes.patches]  # type: ignore[attr-defined]
    np.testing.assert_allclose(heights, ARCSEC * np.abs(report.cycle.harmonics))


def test_the_spread_is_that_of_the_study() -> None:
    """Half of the mountings lie below the median."""
    study = tolerance_study(MODIFIED, USUAL, cases=101)
    axes = Figure().add_subplot()
    charts.spread(axes, study, "contact_ratio", 1.0, "k")
    ratio = study.mountings.contact_ratio[study.mountings.solved]
    at, share = (np.asarray(part) for part in axes.lines[0].get_data())
    assert np.interp(50.0, share, at) == pytest.approx(float(np.median(ratio)), rel=1e-9)
    assert axes.lines[1].get_xdata() == study.nominal.contact_ratio[0]
