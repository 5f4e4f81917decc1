"""Report of `gear-data`: dimensions of both members for their drawings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FLANK_SIGN, MEMBERS, FloatArray
from ...design.ends import end_names
from ...design.member import Member
from ...design.model import Design
from ...findings.backlash import backlash_report
from ...gear.undercut import part_text, pointed_part
from ...pair.mounting import mounting_of
from ...status import BallStatus, SpanStatus
from ...workshop.balls import Balls, ball_dimensions, ball_planes, recommended_ball
from ...workshop.span import Span, span_measurement
from ...workshop.tooth_data import PLACES, ToothData, backlash_change, tooth_data
from ..columns import known_number, label, labelled_lines
from ..result import Failure, Report, Rows, picked, plain, stacked_rows
from ..text import head_lines, line

LIMITS = ("nominal", "upper", "lower")
"""Thicknesses: of the design, with the upper and with the lower allowance."""


@dataclass(frozen=True, eq=False)
class MemberData:
    """Dimensions of one member.

    Attributes
    ----------
    tooth : ToothData
    balls : Balls or None
        None if no usual ball fits.
    span : Span
    distance : ndarray
        Distances (3,) of the planes from the common perpendicular along the axis, mm.
    datum : tuple of float or None
        z of the datum face and its distance from the common perpendicular, mm.
    ends : tuple of str
        Printed names of the ends at -z and +z.
    """

    tooth: ToothData
    balls: Balls | None
    span: Span
    distance: FloatArray
    datum: tuple[float, float] | None
    ends: tuple[str, str]


@dataclass(frozen=True, eq=False)
class GearDataReport(Report):
    """Dimensions of both members of a single design, or the reason why they are unknown.

    `allowances` are the upper and lower allowances of the normal thickness of each member, mm, or None."""

    allowances: tuple[tuple[float, float] | None, ...]
    members: dict[str, MemberData | str]

    @property
    def failure(self) -> Failure | None:
        """Failure if a member has no data."""
        reasons = ((name, data) for name, data in self.members.items() if isinstance(data, str))
        return next((Failure(f"No data of the {name}: {reason}") for name, reason in reasons), None)

    @property
    def backlash(self) -> dict[str, float]:
        """Least normal backlash as mounted at the nominal thickness and at both allowances, mm."""
        given = np.array([(0.0, *(one or (0.0, 0.0))) for one in self.allowances])
        values = backlash_report(self.design).normal + backlash_change(self.design, *given)
        shown = LIMITS if any(self.allowances) else LIMITS[:1]
        return dict(zip(shown, values.tolist(), strict=False))

    def values(self) -> dict[str, Any]:
        """Return the dimensions by member, planes in the order of z; mm and rad."""
        return {
            "places": PLACES,
            "thickness_allowances": dict(zip(MEMBERS, self.allowances, strict=True)),
            "backlash_by_thickness": self.backlash,
            **{
                name: {"reason": data} if isinstance(data, str) else _numbers(data)
                for name, data in self.members.items()
            },
        }

    def rows(self) -> Rows:
        """Return one row for each plane of both members."""
        known = ((name, data) for name, data in self.members.items() if not isinstance(data, str))
        return stacked_rows([dict(_columns(name, data)) for name, data in known])

    def summary(self) -> str:
        """Return a table for each member, and the definitions of the dimensions."""
        text = f"Gear data of {self.name}\n"
        for name, data in self.members.items():
            text += f"\n{name.capitalize()}, {getattr(self.design, name).teeth:g} teeth\n"
            if isinstance(data, str):
                text += line("no data", data)
            else:
                text += _table(name, data) + _pointed_line(getattr(self.design, name))
        text += "\n" + head_lines(self.design)
        words = ", ".join(
            f"{value:.6f} mm {self._thickness(limit)}" for limit, value in self.backlash.items()
        )
        unknown = backlash_report(self.design).unknown
        text += line(
            "normal backlash", f"as mounted not known: {unknown}" if unknown else f"as mounted {words}"
        )
        text += line(
            "normal thickness",
            "on the reference cylinder, perpendicular to the middle of the tooth; chord and height on the"
            " shifted reference cone, the height from the tip; allowances apply to the normal thickness",
        )
        return text + line(
            "over balls",
            "both centres are in the plane z; at the ends of the face, this plane is one ball radius inside"
            " the face",
        )

    def _thickness(self, limit: str) -> str:
        """Return the name of the tooth thickness for which a backlash is given."""
        return "at the nominal thickness" if limit == LIMITS[0] else f"at the {limit} allowances"


def gear_data_report(
    name: str,
    design: Design,
    allowances: tuple[tuple[float, float] | None, ...] = (None, None),
    balls: tuple[float | None, ...] = (None, None),
    spans: tuple[int | None, ...] = (None, None),
    datums: tuple[float | None, ...] = (None, None),
) -> GearDataReport:
    """Return the dimensions of both members of a single design.

    Parameters
    ----------
    name : str
        Name of the design in the report.
    design : Design
        Design of plain numbers.
    allowances : tuple
        Upper and lower allowance of the normal thickness for pinion and gear, mm, or None.
    balls : tuple
        Ball diameters for pinion and gear, mm; None selects the recommended diameter.
    spans : tuple
        Numbers of teeth in the span for pinion and gear; None selects the usual number.
    datums : tuple
        z of the datum faces of pinion and gear, mm, or None.

    Returns
    -------
    GearDataReport
    """
    result: dict[str, MemberData | str] = {}
    distances = mounting_of(design).distance
    given = zip(MEMBERS, allowances, balls, spans, datums, distances.tolist(), strict=True)
    for member_name, limits, ball, teeth, datum, distance in given:
        member, change = getattr(design, member_name), (0.0, *(limits or ()))
        try:
            tooth = tooth_data(member, change)
            diameter = recommended_ball(member) if ball is None else ball
            planes = ball_planes(member, diameter)
            result[member_name] = MemberData(
                tooth=tooth,
                balls=None if np.isnan(diameter) else ball_dimensions(member, diameter, planes, change),
                span=span_measurement(member, teeth, change),
                distance=distance + tooth.z,
                datum=None if datum is None else (datum, distance + datum),
                ends=end_names(member),
            )
        except ValueError as error:
            result[member_name] = str(error)
    return GearDataReport(name, design, allowances, result)


def _measures(one: MemberData) -> dict[str, FloatArray]:
    """Return the dimensions (k, 3) that depend on the allowances by name."""
    names = ("normal_thickness", "chordal_thickness", "chordal_height")
    measures = picked(one.tooth, *names)
    if one.balls is not None:
        measures |= {"ball_dimension": one.balls.dimension, "roll_dimension": one.balls.over_rolls}
    return measures


def _numbers(member: MemberData) -> dict[str, Any]:
    """Return the entries of a member in JSON."""
    tooth, balls, span = member.tooth, member.balls, member.span
    names = ("z", "tip_diameter", "root_diameter", "chord_diameter", "reference_diameter", "root_cone_angle")
    unknown = np.full(len(PLACES), np.nan)
    values = {
        **picked(tooth, *names, "infeed", "swivel"),
        "axial_distance": member.distance,
        **{
            name: dict(zip(FLANK_SIGN, getattr(tooth, name), strict=True))
            for name in ("form_diameter", "base_diameter")
        },
        **{name: _by_limit(rows) for name, rows in _measures(member).items()},
        "span_teeth": span.teeth or None,
        "span": _by_limit(span.dimension.tolist()),
        "span_status": _by_limit(plain(span.status, SpanStatus)),
        "ball_diameter": None if balls is None else balls.diameter,
        "ball_z": unknown if balls is None else balls.z,
    }
    if balls is None:
        values["ball_dimension"] = _by_limit([unknown] * len(tooth.change))
    else:
        values["ball_status"] = _by_limit(plain(balls.status, BallStatus))
    if member.datum is not None:
        values["datum"] = dict(zip(("z", "axial_distance"), member.datum, strict=True))
    return values


def _by_limit(values: Any) -> dict[str, Any]:
    """Return values by the limits of the thickness; without allowances there is only the nominal one."""
    return dict(zip(LIMITS, values, strict=False))


def _columns(name: str, member: MemberData) -> Iterator[tuple[str, Any]]:
    """Yield the columns of a member in CSV."""
    tooth, balls = member.tooth, member.balls
    yield from {
        "member": name,
        "place": PLACES,
        **picked(tooth, "z", "tip_diameter", "root_diameter"),
    }.items()
    for flank, form, base in zip(FLANK_SIGN, tooth.form_diameter, tooth.base_diameter, strict=True):
        yield f"{flank}_form_diameter", form
        yield f"{flank}_base_diameter", float(base)
    yield "axial_distance", member.distance
    if member.datum is not None:
        yield from zip(("datum_z", "datum_axial_distance"), member.datum, strict=True)
    yield from picked(tooth, "reference_diameter", "chord_diameter").items()
    if balls is not None:
        yield from (("ball_diameter", balls.diameter), ("ball_z", balls.z))
    measures = {**_measures(member), "span": member.span.dimension.tolist()}
    for key, rows in measures.items():
        if key == "span":
            yield "span_teeth", member.span.teeth or ""
        yield from ((f"{p}{key}", row) for p, row in zip(("", "upper_", "lower_"), rows, strict=False))
    yield from picked(tooth, "root_cone_angle", "infeed", "swivel").items()


def _table(name: str, one: MemberData) -> str:
    """Return the table of a member."""
    data, balls = one.tooth, one.balls
    back, front = one.ends
    rows = [("z, mm", "z", data.z), ("distance from common perpendicular, mm", "z", one.distance)]
    rows += [(label(key), key, getattr(data, key)) for key in ("tip_diameter", "root_diameter")]
    rows += [
        (f"form diameter, {flank}, mm", "diameter", row)
        for flank, row in zip(FLANK_SIGN, data.form_diameter, strict=True)
    ]
    for key, values in _measures(one).items():
        if np.isnan(values).all() and key == "roll_dimension":
            continue
        if key == "chordal_thickness":
            rows.append(("diameter of the chord, mm", "diameter", data.chord_diameter))
        if key == "ball_dimension" and balls is not None:
            rows.append(("centres of the balls, z, mm", "z", balls.z))
        for limit, change, row in zip(LIMITS, data.change, values, strict=False):
            over = key.removesuffix("_dimension")
            words = label(key) if balls is None or over == key else f"over {over}s of {balls.diameter:g} mm"
            rows.append((words if limit == LIMITS[0] else f"  {limit}, at {change:+g} mm", key, row))
    table: list[tuple[str, Sequence[str]]] = [("", (back, "middle", front))]
    table += [(f"  {words}", [known_number(key, value) for value in row]) for words, key, row in rows]
    return labelled_lines(table, label_width=44, cell_width=16) + _lines(name, one)


def _pointed_line(member: Member) -> str:
    """Return a line for a tooth whose flanks intersect below the tip, otherwise an empty text."""
    ends = pointed_part(member)
    if np.isnan(ends[0]):
        return ""
    where = part_text(ends, 0.5 * float(member.face_width))
    return line("pointed tooth", f"the flanks intersect below the tip diameter {where}")


def _lines(name: str, one: MemberData) -> str:
    """Return the lines with single values of a member and the reasons for missing values."""
    no_ball = (
        "no usual ball touches the flanks above the shifted reference cone: give a diameter with --{}-ball"
    )
    no_rolls = "not defined on a cone, because a roll tilts with the tooth space: use balls"
    data, balls = one.tooth, one.balls
    sides = (f"{value:.4f} mm {flank}" for flank, value in zip(FLANK_SIGN, data.base_diameter, strict=True))
    text = line("base diameters", ", ".join(sides) + f"; reference diameter {data.reference_diameter:.4f} mm")
    angle, swivel = np.degrees((data.root_cone_angle, data.swivel))
    text += line(
        "root cone",
        f"{angle:z.4f} deg to the axis; while the hob is fed by 1 mm towards +z (the {one.ends[1]}), its "
        f"distance from the axis changes by {data.infeed:+z.6f} mm",
    )
    text += line(
        "swivel of the hob", f"{swivel:z.4f} deg about the radial line, without the lead angle of the hob"
    )
    if one.datum is not None:
        z, distance = one.datum
        words = f"{distance:z.4f} mm from the common perpendicular along the axis"
        text += line("datum face", f"at z = {z:z.4f} mm: {words}")
    text += line("span", _span_words(name, one.span))
    if balls is None:
        return text + line("balls", no_ball.format(name))
    if np.isnan(balls.over_rolls).all() and data.root_cone_angle != 0.0:
        text += line("rolls", no_rolls)
    faults = sorted(set(balls.status.ravel().tolist()) - {BallStatus.MEASURED})
    reasons = {
        BallStatus.OFF_FLANK: "a ball touches outside the flanks",
        BallStatus.BELOW_TIP: "a ball lies below the tips",
        BallStatus.ON_BOTTOM: "a ball lies on the bottom land",
        BallStatus.NOT_FOUND: "no position of a ball between the flanks was found",
    }
    return text + "".join(line("balls", reasons[BallStatus(code)]) for code in faults)


def _span_words(name: str, span: Span) -> str:
    """Return the span for each tooth thickness, or the reason why there is none."""
    faults = [SpanStatus(code) for code in span.status.tolist() if code != SpanStatus.MEASURED]
    reasons = {
        SpanStatus.CONE: "not defined on a cone: the base helix angles of right and left flanks differ, so"
        " that no two parallel planes touch both",
        SpanStatus.PARABOLA: "not defined on flanks with a parabola or a modification, which are not"
        " involutes",
        SpanStatus.OFF_FLANK: "the planes touch outside the flanks: give another number of teeth with"
        " --{}-span",
        SpanStatus.FACE_TOO_NARROW: "the face is too narrow: give fewer teeth with --{}-span",
    }
    if faults:
        return reasons[faults[0]].format(name)
    sizes = zip(LIMITS, span.change, span.dimension, strict=False)
    values = (
        f"{size:.4f} mm" if limit == LIMITS[0] else f"{limit} {size:.4f} mm at {change:+g} mm"
        for limit, change, size in sizes
    )
    touched = f"touching at the diameter {span.contact_diameter[0]:.4f} mm"
    return f"over {span.teeth} teeth {', '.join(values)}; {touched}"
