"""The text of a design file gives the same design when it is read again."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np

from beveloid_geom import Design, Errors, Pair, builtin_design
from beveloid_geom.design.file import parse_design
from beveloid_geom.design.text import design_text


def numbers(design: Design) -> list[float]:
    return [float(value) for value in design._quantities()]


def test_all_numbers_are_exact() -> None:
    design = builtin_design()
    odd = replace(
        design.pinion, helix_angle=radians(1.0) / 3.0, profile_shift=0.1 + 0.2, face_width=1.0 / 3.0
    )
    other = replace(design.gear, tool=replace(design.gear.tool, dedendum=1.3, tip_radius=0.3, parabola=-1e-4))
    pair, errors = Pair(228.9123456789, 0.2617, 211.0, 209.5), Errors(0.05, radians(0.01), -0.1, 0.2)
    design = Design(odd, other, pair, errors)
    text = design_text(design, "Two tools, errors and distances")
    assert text.startswith("# Two tools")
    assert text.count("dedendum") == 2
    np.testing.assert_allclose(numbers(parse_design(text)), numbers(design), rtol=3e-16, atol=0)


def test_parabolas_of_each_flank_are_read_again() -> None:
    design = builtin_design().with_parabola(pinion=0.0005)
    pinion = replace(design.pinion, tool=replace(design.pinion.tool, parabola_right=0.001))
    tool = replace(design.gear.tool, parabola_right=-0.001, parabola_left=0.0, parabola_apex=0.7)
    design = replace(design, pinion=pinion, gear=replace(design.gear, tool=tool))
    text = design_text(design)
    assert parse_design(text) == design
    assert "parabola = 0.0005\nparabola_right = 0.001\n" in text
    assert "None" not in text


def test_angles_in_deg_are_rounded() -> None:
    text = design_text(builtin_design())
    assert "helix_angle_deg = -10.57\n" in text
    assert "cone_angle_deg = 0.8\n" in text
