"""Warnings on lengths that were probably given in inches."""

from __future__ import annotations

import pytest

from beveloid_geom import Design
from beveloid_geom.design.file import builtin_text, parse_design
from beveloid_geom.findings.units import unit_remarks


def with_lengths(name: str, factor: float, *keys: str) -> Design:
    """Return a built-in design whose values of the given keys are multiplied by a factor."""
    lines = []
    for line in builtin_text(name).splitlines():
        key, _, value = line.partition("#")[0].partition("=")
        lines.append(f"{key} = {float(value) * factor!r}" if key.strip() in keys else line)
    return parse_design("\n".join(lines))


@pytest.mark.parametrize("key", ["normal_module", "face_width", "offset"])
@pytest.mark.parametrize("name", ["ni-2017", "anti-backlash"])
def test_single_lengths_in_inches_are_named(name: str, key: str) -> None:
    texts = [remark.text for remark in unit_remarks(with_lengths(name, 1.0 / 25.4, key))]
    assert texts
    assert all(text.startswith(f"the {key}") and "was it given in inches?" in text for text in texts)
    wanted = {"normal_module": "6 mm", "face_width": "50 mm", "offset": "229 mm"}[key]
    assert name != "ni-2017" or texts[0].endswith(f"in are {wanted}")


@pytest.mark.parametrize(
    ("module", "expected"), [(1 / 12, True), (0.0625, True), (0.1, False), (0.05, False)]
)
def test_modules_of_usual_diametral_pitches(module: float, expected: bool) -> None:
    """1/12 in is the module of a diametral pitch of 12; 0.1 and 0.05 are standard modules in mm."""
    design = with_lengths("ni-2017", module / 6.0, "normal_module", "face_width", "offset")
    assert bool(list(unit_remarks(design))) is expected
