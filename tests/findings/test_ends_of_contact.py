"""Remarks on contact at tips, roots and ends of faces, on tips below active flanks, and on failed
calculations.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Member,
    Pair,
    Tool,
    builtin_design,
    path_certificate,
    path_of_contact,
    tolerance_study,
)
from beveloid_geom.analysis.tolerance import USUAL, Tolerances
from beveloid_geom.findings.advice import design_remarks
from beveloid_geom.findings.backlash import backlash_report
from beveloid_geom.findings.diagnostics import Remark, quiet
from beveloid_geom.findings.layout import remarks_on
from beveloid_geom.findings.path import first_contact_reason, path_remarks
from beveloid_geom.gear.flank_limits import root_parameter, tip_radius
from beveloid_geom.operation.backlash import mounted_backlash
from beveloid_geom.operation.backlash_by_tangency import Tangency, tangent_backlash
from beveloid_geom.pair.tips import depth_below_tips_as_mounted
from beveloid_geom.proposal.propose import propose
from beveloid_geom.report.result import failure_of
from beveloid_geom.report.tolerance import tolerance_remarks
from beveloid_geom.status import FirstStatus, Limit, NotComputed
from tests.proposal.requests import random_requests

TABLE1 = builtin_design()


def warnings_of(remarks: tuple[Remark, ...]) -> list[str]:
    return [remark.text for remark in remarks if remark.level == "warning"]


def with_tall_gear(addendum: float) -> Design:
    """Return Table 1 with a gear whose tips reach deeper into the pinion."""
    tool = replace(TABLE1.gear.tool, addendum=addendum, dedendum=1.6, tip_radius=0.2)
    return replace(TABLE1, gear=replace(TABLE1.gear, tool=tool))


def test_tips_below_the_form_diameter() -> None:
    """The path ends at the root of the pinion; the tooth of the gear extends beyond by the height in the
    warning."""
    design = with_tall_gear(1.35)
    path = path_of_contact(design, "right", 3)
    assert path.ends.enter == Limit.PINION_ROOT
    assert float(path.l1[0]) == pytest.approx(float(root_parameter(design.pinion, "right")), abs=1e-9)
    over = float(tip_radius(design.gear, path.gear_z[0]) - path.gear_r[0])
    assert over > 0.1
    below = "the tips of the gear reach below the active flank of the pinion (form diameter)"
    texts = warnings_of(tuple(path_remarks(path)))
    assert f"right flanks: {below}: on the gear the path ends {over:.3g} mm below its tips" in texts
    assert not any("form diameter" in text for text in warnings_of(design_remarks(with_tall_gear(1.0))))


def test_contact_at_the_end_of_a_face() -> None:
    narrow = replace(TABLE1, pinion=replace(TABLE1.pinion, face_width=8.0))
    path = path_of_contact(narrow, "left", 3)
    ends = [end for end in (path.ends.enter, path.ends.leave) if end is not None and "e" in end.limit]
    assert {end.limit for end in ends} <= {"toe", "heel", "tip"}
    faces = [end for end in ends if end.limit != "tip"]
    assert faces
    texts = warnings_of(tuple(path_remarks(path)))
    assert all(
        any(f"the contact reaches the {end.member}'s {end.limit}" in text for text in texts) for end in faces
    )


def test_line_contact_at_the_ends_of_the_face_has_no_warning() -> None:
    tool = Tool(2.0, radians(20.0))
    members = [Member(tool, n, side * radians(15.0), 0.0, 0.0, 20.0) for n, side in ((20, 1.0), (50, -1.0))]
    design = Design(members[0], members[1], Pair(72.6, 0.0))
    assert not any("the contact reaches" in remark.text for remark in remarks_on(design))
    for flank in ("right", "left"):
        path = path_of_contact(design, flank, 3)
        assert not any("the contact reaches" in remark.text for remark in path_remarks(path))


def test_deep_tips_away_from_the_path_are_a_note() -> None:
    """The depth is that of `pair.tips`; a certificate shows that the tips touch nothing."""
    design = propose(list(random_requests(89, 11))[88], 1)[0].design
    left = np.minimum(*(depth_below_tips_as_mounted(design.bare(), flank) for flank in ("right", "left")))
    notes = [remark for remark in remarks_on(design) if "form diameter" in remark.text]
    expected = [(name, -depth) for name, depth in zip(("pinion", "gear"), left, strict=True) if depth < 0.0]
    assert expected
    assert len(notes) == len(expected)
    for note, (name, depth) in zip(notes, expected, strict=True):
        assert note.level == "note"
        assert f"{depth:.3g} mm below the active flank of the {name}" in note.text
    assert path_certificate(path_of_contact(design, "right", 9)).holds


def test_remarks_on_mountings_with_contact_at_edges() -> None:
    """A tolerance of 0.06 deg moves more than 2 % of the paths to an end of the face. With parabolas,
    edges are in contact in each of the first 4 mountings."""
    design = TABLE1.with_parabola(0.001, -0.001)
    far = tolerance_study(design, Tolerances(shaft_angle=radians(0.06)), "right", 200, operation=4)
    texts = {
        remark.text.split(" with the tolerances")[0]: remark.level
        for remark in tolerance_remarks(design, far)
    }
    share = np.isin(far.mountings.limit, [k for k in Limit if k.limit in ("toe", "heel")]).any(axis=1).mean()
    assert share > 0.02
    lead, reach = "right flanks:", "of mountings have contact that reaches an end of a face,"
    assert texts[f"{lead} {100.0 * share:.3g} % {reach}"] == "warning"
    carried = "of the first 4 mountings have edge contact during a part of the mesh cycle,"
    assert texts[f"{lead} 100 % {carried}"] == "warning"
    plain = tolerance_study(TABLE1, USUAL, "right", 50, operation=3)
    (pattern,) = tolerance_remarks(TABLE1, plain)
    assert pattern.level == "note"
    reached = "have a contact pattern that reaches an end of a face"
    assert f"100 % of the 3 mountings that move the path furthest {reached}" in pattern.text


@pytest.mark.parametrize("status", list(FirstStatus))
def test_failed_calculation_is_not_no_contact(status: FirstStatus) -> None:
    """Only NO_CONTACT and MEETS_BOTTOM are reported as "no contact", with exit status 1. All other statuses
    are failed calculations, with exit status 4."""
    reason = first_contact_reason("right", status)
    failure = failure_of(reason)
    assert failure is not None
    known = status in (FirstStatus.NO_CONTACT, FirstStatus.MEETS_BOTTOM)
    assert isinstance(reason, NotComputed) is not known
    assert failure.status == (1 if known else 4)
    assert failure.text.startswith("No contact: " if known else "Not computed: ")
    assert ("could not be computed" in failure.text) is not known


def test_an_unknown_is_not_quiet() -> None:
    assert not quiet([Remark("unknown", "a search did not converge")])


TOOL = Tool(1.0, radians(20.0), 1.181105, 1.281105, 0.25)
FILLETED = Design(
    Member(TOOL, 37, radians(2.595824), radians(-2.721465), -0.051219, 13.0311),
    Member(TOOL, 40, radians(7.565377), radians(7.792675), 0.252871, 13.868599),
    Pair(35.10467759124015, 0.19684965521252076),
)


def test_tangency_near_fillets_is_an_estimate() -> None:
    """If a tip touches a fillet, the teeth have less backlash than the tangency of their flanks, which is
    called an estimate."""
    design = FILLETED
    mounted, tangent = mounted_backlash(design), tangent_backlash(design)
    assert mounted.right.on_fillet.any() or mounted.left.on_fillet.any()
    assert float(mounted.normal) < float(tangent.normal) - 0.005
    assert int(tangent.status) == Tangency.ESTIMATE
    assert int(tangent_backlash(TABLE1).status) == Tangency.TOUCHES


def test_no_negative_zero_in_the_roll_of_the_backlash() -> None:
    report = backlash_report(builtin_design())
    assert report.backlash is not None
    at_zero = replace(report, backlash=replace(report.backlash, pinion_roll=np.array(-1e-9)))
    assert "at a pinion roll of 0.0000 deg" in at_zero.line
