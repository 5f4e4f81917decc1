"""The command `beveloid-geom gear-data`."""

from __future__ import annotations

from ... import results
from ...options import NumberRange, Refusal, block, option, override_options

ALLOWANCES = "Upper and lower allowance of the {}'s normal thickness; a thinner tooth's are negative."
BALL = "Diameter of the balls between the {}'s teeth.  [default: a usual one that touches at half depth]"
MOST = 0.3
"""Modules of an allowance: a tooth is half a pitch thick, and no allowance takes a fifth of that."""


@results.result_command(
    *(
        block(
            option(f"--{member}-allowances", (float, float), None, ALLOWANCES.format(member), "UPPER LOWER"),
            option(f"--{member}-ball", NumberRange(0.01, 1000.0), None, BALL.format(member), "MM"),
        )
        for member in ("pinion", "gear")
    ),
    override_options,
    csv="a plane of a member a row",
)
def gear_data(
    name: str,
    design: results.Design,
    pinion_allowances: tuple[float, float] | None,
    gear_allowances: tuple[float, float] | None,
    pinion_ball: float | None,
    gear_ball: float | None,
) -> results.Result:
    """Give what the drawings of both members need, at toe, middle and heel.

    Tip, root and form diameters, normal thickness, chord and its height, dimension over two balls; base
    diameters, root cone, and how the hob is set. With allowances all measures at both, and the backlash that
    follows. Exit status 1 if the tool of a member leaves no flanks to measure.
    """
    from ....report.workshop.gear_data import gear_data_report

    allowances = pinion_allowances, gear_allowances
    for member, given in zip(("pinion", "gear"), allowances, strict=True):
        if given is not None:
            _require_allowances(member, given, MOST * float(design.pinion.tool.normal_module))
    return gear_data_report(name, design, allowances, (pinion_ball, gear_ball))


def _require_allowances(member: str, given: tuple[float, float], most: float) -> None:
    """Refuse allowances in the wrong order or unit."""
    lead, (upper, lower) = f"--{member}-allowances", given
    if not all(abs(value) <= most for value in given):
        cure = "were they given in um?"
        raise Refusal([f"{lead} must be between -{most:g} and {most:g} mm, got {upper:g} {lower:g}: {cure}"])
    if upper < lower:
        raise Refusal(
            [f"{lead} must be the upper and then the lower one, got {upper:g} {lower:g}: swap them"]
        )
