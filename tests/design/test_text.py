"""A design written as a file and read again."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Pair, Tool, builtin_design
from beveloid_geom.design.file import parse_design
from beveloid_geom.design.text import design_text


def numbers(design: Design) -> list[float]:
    return [float(value) for value in design._quantities()]


@pytest.mark.parametrize("name", ["ni-2017", "awd-transfer", "marine-gearbox"])
def test_built_in_designs_come_back(name: str) -> None:
    design = builtin_design(name)
    assert parse_design(design_text(design)) == design


def test_all_numbers_come_back_to_the_last_digit() -> None:
    design = builtin_design()
    odd = replace(
        design.pinion, helix_angle=radians(1.0) / 3.0, profile_shift=0.1 + 0.2, face_width=1.0 / 3.0
    )
    other = replace(design.gear, tool=replace(design.gear.tool, dedendum=1.3, tip_radius=0.3, parabola=-1e-4))
    pair, errors = Pair(228.9123456789, 0.2617, 211.0, 209.5), Errors(0.05, radians(0.01), -0.1, 0.2)
    design = Design(odd, other, pair, errors)
    text = design_text(design, "Two tools, errors and distances: nothing may be left out.")
    assert text.startswith("# Two tools")
    np.testing.assert_allclose(numbers(parse_design(text)), numbers(design), rtol=3e-16, atol=0)


def test_a_number_that_has_few_digits_in_deg_is_written_with_them() -> None:
    text = design_text(builtin_design())
    assert "helix_angle_deg = -10.57\n" in text
    assert "cone_angle_deg = 0.8\n" in text


def test_a_tool_of_its_own_stays_with_its_member() -> None:
    gear = builtin_design().gear
    design = replace(builtin_design(), gear=replace(gear, tool=Tool(6.0, radians(20.0), dedendum=1.3)))
    text = design_text(design)
    assert text.count("dedendum") == 2
    assert parse_design(text) == design


def test_arrays_are_refused() -> None:
    with pytest.raises(ValueError, match=r"arrays of shape \(2,\)"):
        design_text(builtin_design().with_errors(Errors(offset=np.array([0.0, 0.1]))))
