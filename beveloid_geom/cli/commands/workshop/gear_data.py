"""The command `beveloid-geom gear-data`."""

from __future__ import annotations

from typing import Any

import click

from ... import results
from ...options import MEMBERS, NumberRange, Option, Refusal, block, option, override_options


def _member_options(member: str) -> Option:
    """Return the options for the drawing of one member."""
    return block(
        option(
            f"--{member}-allowances",
            (float, float),
            None,
            f"Upper and lower allowance of the normal thickness of the {member}, mm; negative for thinner"
            " teeth.",
            "UPPER LOWER",
        ),
        option(
            f"--{member}-ball",
            NumberRange(0.01, 1000.0),
            None,
            f"Diameter of the balls for the {member}.  [default: the smallest usual diameter of measuring"
            " balls (0.17 to 200 mm) with which a ball at mid-face touches both flanks on or above the"
            " shifted reference cone]",
            "MM",
        ),
        option(
            f"--{member}-span",
            click.IntRange(min=1),
            None,
            f"Number of teeth in the span of a cylindrical {member}.  [default: contact nearest to the"
            " V-cylinder]",
            "TEETH",
        ),
        option(
            f"--{member}-datum",
            NumberRange(-1e4, 1e4),
            None,
            f"z of the datum face of the {member} from mid-face; its distance from the common perpendicular"
            " is printed.",
            "MM",
        ),
    )


@results.result_command(
    *map(_member_options, MEMBERS),
    override_options,
    csv="one plane of a member per row",
)
def gear_data(name: str, design: results.Design, **given: Any) -> results.Result:
    """Compute the data for the drawings of both members, at both ends and in the middle of the face.

    The data are tip, root and form diameters, normal thickness, chordal thickness and height, the dimension
    over two balls, base diameters, root cone and setting of the hob, and the distances of the end faces or of
    a datum face from the common perpendicular of the axes. For cylindrical gears, the dimension over two
    rolls and the span over k teeth are added. With allowances, the dimensions at both limits and the
    resulting backlash are added. The exit status is 1 if the tool of a member leaves no flanks to measure."""
    # Largest allowance. A tooth is about 1.57 modules thick, and allowances are less than a fifth of
    # this.
    max_allowance_modules = 0.3
    from ....report.workshop.gear_data import gear_data_report

    allowances, balls, spans, datums = (
        tuple(given[f"{member}_{kind}"] for member in MEMBERS)
        for kind in ("allowances", "ball", "span", "datum")
    )
    largest = max_allowance_modules * float(design.pinion.tool.normal_module)
    for member, limits in zip(MEMBERS, allowances, strict=True):
        if limits is not None:
            _require_allowances(member, limits, largest)
    for member, teeth in zip(MEMBERS, spans, strict=True):
        most = int(getattr(design, member).teeth) - 1
        if teeth is not None and teeth > most:
            limit = f"be between 1 and {most}, got {teeth}"
            raise Refusal([f"--{member}-span must {limit}: the {member} has {most + 1} teeth"])
    return gear_data_report(name, design, allowances, balls, spans, datums)


def _require_allowances(member: str, given: tuple[float, float], most: float) -> None:
    """Raise Refusal for allowances in the wrong order or unit."""
    lead, (upper, lower) = f"--{member}-allowances", given
    if not all(abs(value) <= most for value in given):
        cure = "were they given in um?"
        raise Refusal([f"{lead} must be between -{most:g} and {most:g} mm, got {upper:g} {lower:g}: {cure}"])
    if upper < lower:
        limit = "be the upper and then the lower allowance"
        raise Refusal([f"{lead} must {limit}, got {upper:g} {lower:g}: swap them"])
