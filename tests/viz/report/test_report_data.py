"""Data of the report page: dates, failing mountings, tolerances, charts and progress."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Pair, Tolerances, builtin_design, tolerance_study
from beveloid_geom.analysis.tolerance import MOUNTINGS_PER_BLOCK, USUAL
from beveloid_geom.design.file import BUILTINS, builtin_text
from beveloid_geom.findings.advice import design_remarks
from beveloid_geom.report.tolerance import ToleranceReport, tolerance_remarks
from beveloid_viz.report import svg
from beveloid_viz.report.cli import _written
from beveloid_viz.report.data import ReportSettings, _tolerances, compute, failed_mountings
from tests.symmetry import scaled


def test_the_time_of_a_copied_file_is_not_later_than_the_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SOURCE_DATE_EPOCH limits the date, so that the page of a new copy is identical."""
    file = tmp_path / "pair.toml"
    file.write_text(builtin_text(), encoding="utf-8")
    os.utime(file, (1e9, 1e9))
    assert [_written(name) for name in BUILTINS] == [None] * len(BUILTINS)
    for epoch, expected in ((None, 1e9), ("1000000007", 1e9), ("999999999", 999999999.0)):
        if epoch:
            monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
        found = _written(str(file))
        assert found is not None
        assert found.timestamp() == expected


def test_failing_mountings_are_counted_once() -> None:
    """The counts of three kinds of failures equal those of both flanks; a mounting with several
    failures counts once."""
    design = builtin_design().with_errors(Errors(offset=-0.11))
    wide = Tolerances(0.1, math.radians(0.5), 0.1, 0.1)
    studies = [tolerance_study(design, wide, flank, 300) for flank in ("right", "left")]
    found, sides = failed_mountings(list(studies)), [study.mountings for study in studies]
    lost, short, jammed = (
        np.logical_or(*flanks)
        for flanks in (
            [~one.solved for one in sides],
            [one.solved & (one.contact_ratio < 1.0) for one in sides],
            [one.jammed for one in sides],
        )
    )
    counts = {"without_contact": lost.sum(), "contact_ratio_below_1": short.sum(), "jammed": jammed.sum()}
    failed = lost | short | jammed
    unknown = np.any([np.isnan(one.normal_backlash) for one in sides], axis=0) & ~failed
    assert found == {"cases": 300, "failed": failed.sum(), **counts, "jam_unknown": unknown.sum()}
    assert 0 < lost.sum() < 300
    assert 0 < jammed.sum() < 300
    assert failed_mountings([None, None]) == {}


def test_failing_mountings_give_a_warning() -> None:
    """The right flanks of this pair have no contact in about 15 % of the mountings."""
    table1 = builtin_design()
    tool = replace(table1.pinion.tool, normal_module=4.0)
    pinion = replace(table1.pinion, tool=tool, teeth=25)
    cone, helix, shaft = map(math.radians, (5.0, -6.64, 20.0))
    gear = replace(table1.gear, tool=tool, teeth=31, cone_angle=cone, helix_angle=helix)
    design = Design(pinion, gear, Pair(111.6066, shaft))
    study = tolerance_study(design, USUAL, "right", 100)
    remark, reach = tolerance_remarks(design, study)
    share = 1.0 - np.count_nonzero(study.mountings.solved) / study.cases
    assert 0.08 < share < 0.25
    assert remark.level == "warning"
    assert remark.text.startswith(f"right flanks: {100.0 * share:.3g} % of mountings have no contact")
    assert reach.text.startswith("right flanks: 15 % of mountings have contact that reaches an end of a face")
    assert ToleranceReport("own", design, study).data()["warnings"] == [remark.text, reach.text]
    texts = [found.text for found in design_remarks(design) if found.level == "warning"]
    assert texts[0].startswith("right flanks: sensitive to errors")
    assert "0.01 deg of shaft angle shifts the path on the pinion by 57.3 mm along the face" in texts[0]
    assert texts[1].endswith("at an error of shaft angle +0.01 deg or shaft angle -0.01 deg")
    assert tolerance_remarks(design, tolerance_study(design, USUAL, "left", 100)) == ()


def test_usual_tolerances_too_wide_for_a_pair_are_a_reason_and_given_ones_a_refusal() -> None:
    design = scaled(builtin_design(), 0.004 / 6.0)  # 0.05 mm are more than ten modules
    done = list[str]()
    found = _tolerances("small", design, ReportSettings(cases=5), done.append, None)
    for result, data, reason in found.values():
        assert result is None
        assert data["reason"] == reason
        assert "tolerance of offset must be less" in str(reason)
    with pytest.raises(ValueError, match="tolerance of offset must be less"):
        _tolerances("small", design, ReportSettings(Tolerances(offset=1.0), True, 5), done.append, None)


def test_charts_keep_their_numbers_and_share_no_ids() -> None:
    with svg.chart_style():
        chart = svg.new_chart(100.0)
        axes = chart.add_subplot()
        axes.plot([0.0, 1.0], [0.0, 1.0])
        axes.text(0.1234567, 0.5, "0.0006 & 1.23456 <b>")
        axes.set_title("heading", fontweight="bold")
        one, two = (svg.svg_of(chart, name, "<&>") for name in ("one", "two"))
    assert "0.0006 &amp; 1.23456 &lt;b&gt;" in one
    assert ">&lt;&amp;&gt;</title>" in one
    assert len(re.findall("font-weight: (?:bold|700)", one)) == 1
    ids = re.findall(r'\bid="([^"]*)"', one)
    assert ids
    assert not set(ids) & set(re.findall(r'\bid="([^"]*)"', two))
    assert set(re.findall(r'(?:href="|url\()#([^")]*)', one)) <= set(ids)
    assert not re.search(r'd="[^"]*\d\.\d{3}', one)


@pytest.mark.slow
def test_progress_counts_the_mountings() -> None:
    calls: list[str] = []
    settings = ReportSettings(cases=2 * MOUNTINGS_PER_BLOCK + 1)
    compute("ni-2017", builtin_design(), settings, calls.append)
    assert len(calls) == settings.steps
    assert calls.count("tolerance") == 1 + 3
