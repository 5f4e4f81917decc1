"""The dimensions of both members of a pair for their drawings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FLANK_SIGN, FloatArray
from ...design.model import Design
from ...findings.backlash import backlash_report
from ...status import BallStatus
from ...workshop.balls import Balls, ball_planes, balls_at, recommended_ball
from ...workshop.tooth_data import PLACES, ToothData, backlash_change, tooth_data
from ..columns import label, number
from ..result import Rows
from ..words import head_lines, layout_data, line, name_in_files

MEMBERS = ("pinion", "gear")
LIMITS = ("nominal", "upper", "lower")
"""Of a measure: of the design, at the upper and at the lower allowance of the thickness."""
WIDTHS = 44, 16
"""Characters of the names and of a plane in a text."""
WORDS = {
    BallStatus.OFF_FLANK: "a ball touches beside the flanks",
    BallStatus.BELOW_TIP: "a ball lies below the tips",
    BallStatus.ON_BOTTOM: "a ball lies on the bottom land",
    BallStatus.NOT_FOUND: "a ball finds no place between the flanks",
}


@dataclass(frozen=True, eq=False)
class GearDataReport:
    """The dimensions `found` of both members of a single design, by name; where there are none, why.

    `allowances`: upper and lower one of the normal thickness of each, mm, None if none are given."""

    name: str
    design: Design
    allowances: tuple[tuple[float, float] | None, ...]
    found: dict[str, tuple[ToothData, Balls] | str]

    @property
    def failure(self) -> str | None:
        """Why there is nothing for a member."""
        faults = (f"No data of the {name}: {one}" for name, one in self.found.items() if isinstance(one, str))
        return next(faults, None)

    @property
    def backlash(self) -> dict[str, float]:
        """The least normal backlash as mounted, mm, at the nominal thickness and at both allowances."""
        given = np.array([(0.0, *(one or (0.0, 0.0))) for one in self.allowances])
        values = backlash_report(self.design).normal + backlash_change(self.design, *given)
        shown = LIMITS if any(self.allowances) else LIMITS[:1]
        return dict(zip(shown, values.tolist(), strict=False))

    def data(self) -> dict[str, Any]:
        """Give the dimensions by member, planes toe first; mm and rad."""
        data = layout_data(self.name, self.design)
        data |= {"places": PLACES, "thickness_allowances": dict(zip(MEMBERS, self.allowances, strict=True))}
        data["backlash_by_thickness"] = self.backlash
        for name, one in self.found.items():
            data[name] = {"reason": one} if isinstance(one, str) else _numbers(*one)
        return data

    def rows(self) -> Rows:
        """Give the planes of both members."""
        known = {name: one for name, one in self.found.items() if not isinstance(one, str)}
        tables = [dict(_columns(name, *one)) for name, one in known.items()]
        names = max(tables, key=len, default={})
        nothing = [""] * len(PLACES)
        return {name: [cell for table in tables for cell in table.get(name, nothing)] for name in names}

    def summary(self) -> str:
        """Write a table for each member, and what the measures are."""
        text = f"Gear data of {self.name}\n"
        for name, one in self.found.items():
            text += f"\n{name.capitalize()}, {getattr(self.design, name).teeth:g} teeth\n"
            text += line("none", one) if isinstance(one, str) else _table(*one)
        text += "\n" + head_lines(self.design)
        words = (f"{value:.6f} mm {self._thickness(limit)}" for limit, value in self.backlash.items())
        text += line("normal backlash", f"as mounted {', '.join(words)}")
        text += line(
            "normal thickness",
            "on the reference cylinder, square to the tooth's middle; chord and height on the shifted"
            " reference cone, the height from the tip; allowances are of the thickness",
        )
        return text + line(
            "over balls", "both centres in the plane z, at toe and heel a ball's radius inside the face"
        )

    def _thickness(self, limit: str) -> str:
        """Say with which thickness."""
        return "at the nominal thickness" if limit == LIMITS[0] else f"at the {limit} allowances"


def gear_data_report(
    name: str,
    design: Design,
    allowances: tuple[tuple[float, float] | None, ...] = (None, None),
    balls: tuple[float | None, ...] = (None, None),
) -> GearDataReport:
    """Find the dimensions of both members of a single design.

    `allowances` of pinion and gear: upper and lower, mm; `balls`: diameters, mm, None for the recommended."""
    found: dict[str, tuple[ToothData, Balls] | str] = {}
    for member_name, limits, ball in zip(MEMBERS, allowances, balls, strict=True):
        member, change = getattr(design, member_name), (0.0, *(limits or ()))
        try:
            data = tooth_data(member, change)
            diameter = recommended_ball(member) if ball is None else ball
            if np.isnan(diameter):
                raise ValueError("no usual ball touches its flanks above the shifted reference cone")
            found[member_name] = data, balls_at(member, diameter, ball_planes(member, diameter), change)
        except ValueError as error:
            found[member_name] = str(error)
    return GearDataReport(name, design, allowances, found)


def _measures(data: ToothData, balls: Balls) -> dict[str, FloatArray]:
    """Give what the allowances change, (k, 3), by name."""
    names = ("normal_thickness", "chordal_thickness", "chordal_height")
    return {name: getattr(data, name) for name in names} | {"ball_dimension": balls.dimension}


def _numbers(data: ToothData, balls: Balls) -> dict[str, Any]:
    """Give the entries of a member in JSON."""
    status = [[name_in_files(BallStatus(code)) for code in row] for row in balls.status.tolist()]
    sides = {
        name: dict(zip(FLANK_SIGN, getattr(data, name), strict=True))
        for name in ("form_diameter", "base_diameter")
    }
    single = ("reference_diameter", "root_cone_angle", "infeed", "swivel")
    along = ("z", "tip_diameter", "root_diameter", "chord_diameter")
    return {
        **{name: getattr(data, name) for name in (*along, *single)},
        **sides,
        **{name: dict(zip(LIMITS, rows, strict=False)) for name, rows in _measures(data, balls).items()},
        "ball_diameter": balls.diameter,
        "ball_z": balls.z,
        "ball_status": dict(zip(LIMITS, status, strict=False)),
    }


def _columns(name: str, data: ToothData, balls: Balls) -> Iterator[tuple[str, list[Any]]]:
    """Give the columns of a member in CSV."""
    planes = len(PLACES)
    yield "member", [name] * planes
    yield "place", list(PLACES)
    for key in ("z", "tip_diameter", "root_diameter"):
        yield key, getattr(data, key).tolist()
    for flank, form, base in zip(FLANK_SIGN, data.form_diameter, data.base_diameter, strict=True):
        yield f"{flank}_form_diameter", form.tolist()
        yield f"{flank}_base_diameter", [float(base)] * planes
    for key, value in (("reference_diameter", data.reference_diameter), ("ball_diameter", balls.diameter)):
        yield key, [value] * planes
    yield "chord_diameter", data.chord_diameter.tolist()
    yield "ball_z", balls.z.tolist()
    for key, rows in _measures(data, balls).items():
        for limit, row in zip(("", "upper_", "lower_"), rows, strict=False):
            yield f"{limit}{key}", row.tolist()
    for key in ("root_cone_angle", "infeed", "swivel"):
        yield key, [getattr(data, key)] * planes


def _table(data: ToothData, balls: Balls) -> str:
    """Write the dimensions of a member."""
    first, width = WIDTHS
    text = f"{'':{first}}" + "".join(f"{place:>{width}}" for place in PLACES) + "\n"
    rows = [("z, mm", "z", data.z)]
    rows += [(label(name), name, getattr(data, name)) for name in ("tip_diameter", "root_diameter")]
    rows += [
        (f"form diameter, {flank}, mm", "diameter", row)
        for flank, row in zip(FLANK_SIGN, data.form_diameter, strict=True)
    ]
    for name, values in _measures(data, balls).items():
        if name == "chordal_thickness":
            rows.append(("diameter of the chord, mm", "diameter", data.chord_diameter))
        if name == "ball_dimension":
            rows.append(("centres of the balls, z, mm", "z", balls.z))
        for limit, change, row in zip(LIMITS, data.change, values, strict=False):
            words = f"over balls of {balls.diameter:g} mm" if name == "ball_dimension" else label(name)
            rows.append((words if limit == LIMITS[0] else f"  {limit}, at {change:+g} mm", name, row))
    for words, name, row in rows:
        cells = (f"{'-':>{width}}" if np.isnan(value) else number(name, value, width) for value in row)
        text += f"  {words:<{first - 2}}" + "".join(cells) + "\n"
    sides = (f"{value:.4f} mm {flank}" for flank, value in zip(FLANK_SIGN, data.base_diameter, strict=True))
    text += line(
        "base diameters", ", ".join(sides) + f"; reference diameter {data.reference_diameter:.4f} mm"
    )
    angle, swivel = np.degrees((data.root_cone_angle, data.swivel))
    text += line(
        "root cone", f"{angle:.4f} deg to the axis; radial infeed {data.infeed:.6f} mm a mm towards the heel"
    )
    text += line("hob's swivel", f"{swivel:z.4f} deg about the radial line, without the hob's own lead")
    faults = sorted(set(balls.status.ravel().tolist()) - {BallStatus.MEASURED})
    return text + "".join(line("balls", WORDS[BallStatus(code)]) for code in faults)
