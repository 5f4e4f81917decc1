"""Printed names of the ends of a face: the heel is the large end. Codes are assigned by z."""

from __future__ import annotations

import csv
import io
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from beveloid_geom import Design, Errors, Member, builtin_design
from beveloid_geom.analysis.pressure import Load
from beveloid_geom.cli.main import main
from beveloid_geom.design.ends import end_names
from beveloid_geom.findings.backlash import backlash_data, backlash_report
from beveloid_geom.findings.diagnostics import tooth_remarks
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.report.ease_off import ease_off_report
from beveloid_geom.report.operation import operation_report
from beveloid_geom.report.path import contact_report
from beveloid_geom.report.result import csv_text
from beveloid_geom.report.workshop.gear_data import gear_data_report
from tests.symmetry import exchanged

BUILTINS = ("ni-2017", "awd-transfer", "marine-gearbox", "anti-backlash")


def coned(cone_deg: float) -> Member:
    member = builtin_design("anti-backlash").pinion
    return replace(member, cone_angle=np.radians(cone_deg), profile_shift=0.0)


def spur() -> Design:
    design = builtin_design("anti-backlash")
    return replace(
        design,
        pinion=replace(design.pinion, cone_angle=0.0),
        gear=replace(design.gear, cone_angle=0.0),
    )


DESIGNS = {
    **{name: builtin_design(name) for name in BUILTINS},
    "negative cone on the pinion": exchanged(builtin_design("anti-backlash")),
    "cylindrical": spur(),
}


@pytest.mark.parametrize("cone_deg", [-30.0, -3.0, -1e-6, 1e-6, 3.0, 30.0])
def test_the_heel_is_the_larger_end(cone_deg: float) -> None:
    member = coned(cone_deg)
    back, front = (float(tip_radius(member, z)) for z in (-5.0, 5.0))
    names = end_names(member)
    assert set(names) == {"toe", "heel"}
    assert names[int(front > back)] == "heel"
    assert end_names(coned(0.0)) == ("back", "front")


@pytest.mark.parametrize("name", DESIGNS)
def test_gear_data_have_the_larger_tip_at_the_heel(name: str) -> None:
    design = DESIGNS[name]
    report = gear_data_report(name, design)
    tables = report.summary().split("teeth\n")[1:]
    for member, table in zip(design.members, tables, strict=True):
        heads = table.splitlines()[0].split()
        tips = [float(x) for x in re.findall(r"tip diameter, mm +(.*)", table)[0].split()]
        if float(member.cone_angle) == 0.0:
            assert heads == ["back", "middle", "front"]
        else:
            assert sorted(heads) == ["heel", "middle", "toe"]
            assert heads[int(np.argmax(tips))] == "heel"
    rows = list(csv.DictReader(io.StringIO(csv_text(report.rows()))))
    for row in rows:  # codes are assigned by z
        assert row["place"] == {-1: "toe", 0: "middle", 1: "heel"}[int(np.sign(float(row["z_mm"])))]


def test_edges_in_contact() -> None:
    """Edges in contact have the printed names of the ends of the face, and the codes of these ends. The pair
    has convex flanks, a shaft-angle error, and a gear with a negative cone angle."""
    design = builtin_design("anti-backlash").with_parabola(-0.0005, -0.0005)
    exchanged_names = False
    for angle in (-0.003, 0.003):
        report = operation_report("x", design.with_errors(Errors(shaft_angle=angle)), "right", 25, 1, 0.006)
        for code, word in zip(report.carriers, report.carriers_in_print, strict=True):
            swapped = {"gear toe": "gear heel", "gear heel": "gear toe"}.get(code, code)
            assert word == swapped
            exchanged_names |= code != word
        assert report.positions["carried_by"] == report.carriers
        assert set(report.carriers_in_print) & set(re.findall(r"gear \w+", report.summary()))
    assert exchanged_names


def test_printed_ends_of_lines_of_contact() -> None:
    report = contact_report("x", builtin_design("anti-backlash"), "right", 5)
    text = report.summary()
    assert "gear heel to gear toe" in text  # from -z to +z
    assert "flanks touch at" not in text  # lines of contact
    assert report.data()["contact_lines"]["limit"][2] == ["gear_toe", "gear_heel"]


def test_edges_that_limit_the_backlash() -> None:
    """The printed edges that limit the backlash are named by size, on a gear with a negative cone angle."""
    design = builtin_design("anti-backlash").with_parabola(-0.0005, -0.0005)
    design = design.with_errors(Errors(shaft_angle=0.002))
    backlash = backlash_data(design)["mounted_backlash"]
    assert backlash["right"]["edges"] == [{"member": "gear", "limit": "toe"}]  # at -z
    assert backlash["left"]["edges"] == [{"member": "gear", "limit": "heel"}]
    words = "right flanks touch at the gear's heel and left flanks touch at the gear's toe"
    assert words in backlash_report(design).line


def test_pointed_teeth() -> None:
    """The tooth is pointed at the heel, where the profile shift is largest, for both signs of the cone
    angle."""
    for sign in (-1.0, 1.0):
        member = replace(coned(sign * 12.0), profile_shift=0.3, face_width=20.0)
        texts = [remark.text for remark in tooth_remarks("pinion", member) if "pointed" in remark.text]
        assert len(texts) == 1
        assert "pointed at the heel" in texts[0]


def test_teeth_pointed_along_the_complete_face() -> None:
    """The tooth of Table 1 is pointed at both ends with a profile shift of 2.2: one remark."""
    member = replace(builtin_design().pinion, profile_shift=2.2)
    texts = [remark.text for remark in tooth_remarks("pinion", member) if "pointed" in remark.text]
    cure = "reduce the profile shift or the addendum"
    assert texts == [f"the tooth of the pinion is pointed along the complete face: {cure}"]


def test_corners_of_the_ease_off() -> None:
    """If the cone angle of the pinion is negative, the printed heel is the end at -z, whose code is toe."""
    design = exchanged(builtin_design("anti-backlash")).with_parabola(-0.001, -0.0005)
    report = ease_off_report("x", design, (5, 5))
    text = report.summary()
    for row in ("root", "tip"):
        line = re.search(rf"  {row}, heel +(.*)", text)
        assert line is not None
        code = report.data()["right"]["as_given"]["corners"][f"{row}_toe"]
        assert float(line[1].split()[0]) == pytest.approx(1e3 * code, abs=1e-3)
    assert "x runs from -1 at the heel to 1 at the toe" in " ".join(text.split())


def test_edges_that_the_pressure_ellipse_passes() -> None:
    design = builtin_design("anti-backlash").with_parabola(-0.0005, -0.0005)
    report = contact_report("x", design, "right", 9, load=Load(force=5e4))
    assert {"gear_toe", "gear_heel"} <= set(report.data()["hertz"]["reaches"])
    assert "(gear heel, gear toe)" in report.summary()  # in the order of the codes, -z first


def test_statements_name_the_ends_of_the_paper() -> None:
    paper, other = (CliRunner().invoke(main, ["statements", name]).output for name in BUILTINS[:2])
    words = "the paper's toe and heel are the ends of the face at -z and +z"
    assert words in other
    assert words not in paper
