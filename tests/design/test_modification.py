"""Modifications in design files and in Python."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from beveloid_geom import DesignError, Modification, builtin_design, design_text
from beveloid_geom.design.file import parse_design
from beveloid_geom.design.modification import kinds_of, length_of

from .table1_file import faults_in

FILE = design_text(builtin_design())
FAULTS = {
    "helix_crown_um = 1.0": "helix_crown_um is unknown: did you mean helix_crowning_um?",
    "lead_crowning_um = 1.0": "lead_crowning_um is unknown: did you mean helix_crowning_um?",
    "tip_relief_um = 3.0": "[pinion.modification] tip_relief_um needs tip_relief_length_mm",
    "toe_relief_length_mm = 3.0": "[pinion.modification] toe_relief_length_mm needs toe_relief_um",
    "twist_um = nan": "[pinion.modification] twist_um must be a finite number, got nan",
    "twist_um = inf": "[pinion.modification] twist_um must be a finite number, got inf",
    "twist_um = '0.01 mm'": "got '0.01 mm': give it in um without a unit, 10",
    "twist_um = 10,5": "twist_um must be a number, got '10,5': write it with a decimal point",
    "helix_slope_um = -10000.0": "be between -9425 and 9425 um, the thickness of the tooth, got -10000.0",
    "tip_relief_um = 9.0\ntip_relief_length_mm = 20.0": "must be at most 12.77 mm, the length",
    "toe_relief_um = 9.0\ntoe_relief_length_mm = 51.0": "toe_relief_length_mm must be at most 50 mm",
    "toe_relief_um = 9.0\ntoe_relief_length_mm = -1.0": "must be between 1e-06 and 10000 mm, got -1.0",
    "upper.twist_um = 1.0": "upper is unknown: tables for one flank are right and left",
    "right = 3.0": "[pinion.modification.right] must be a table, got 3.0",
    "right.twist_um = true": "[pinion.modification.right] twist_um must be a number, got true",
}


@pytest.mark.parametrize("line", FAULTS)
def test_faults_are_one_line(line: str) -> None:
    (fault,) = faults_in(f"{FILE}\n[pinion.modification]\n{line}\n")
    assert FAULTS[line] in fault


def test_a_table_for_one_flank_replaces_the_table_for_both() -> None:
    text = f"{FILE}\n[gear.modification]\nhelix_crowning_um = 10.0\n"
    both = parse_design(text)
    assert both.gear.modification_right == both.gear.modification_left == Modification(helix_crowning_um=10.0)
    assert both.pinion == builtin_design().pinion
    one = parse_design(f"{text}[gear.modification.left]\ntwist_um = -4\n")
    assert one.gear.modification_right == Modification(helix_crowning_um=10.0)
    assert one.gear.modification_left == Modification(twist_um=-4.0)
    faulty = f"{text}twist = 1.0\n[gear.modification.left]\n[gear.modification.right]\n"
    assert "twist is unknown" in "".join(faults_in(faulty))


def test_files_are_read_as_they_were_written() -> None:
    every: dict[str, Any] = {name: 3.0 + k for k, name in enumerate(kinds_of())}
    lengths: dict[str, Any] = {length_of(name): 2.5 for name, kind in kinds_of().items() if kind.has_length}
    design = builtin_design()
    pinion = design.pinion.modified(Modification(**every, **lengths))
    gear = design.gear.modified(Modification(tip_relief_um=0.0, tip_relief_length_mm=1.0), "left")
    changed = replace(design, pinion=pinion, gear=gear)
    assert parse_design(design_text(changed)) == changed
    assert hash(changed) == hash(parse_design(design_text(changed)))


def test_values_from_python() -> None:
    with pytest.raises(DesignError, match="tip_relief_um needs tip_relief_length_mm"):
        Modification(tip_relief_um=1.0)
    with pytest.raises(DesignError, match="twist_um must be a finite number, got nan at"):
        Modification(twist_um=np.array([1.0, np.nan]))
    member = builtin_design().pinion
    with pytest.raises(DesignError, match="modification_left must be of the class Modification"):
        replace(member, modification_left=cast(Any, 5.0))
    several = replace(builtin_design(), pinion=member.modified(Modification(twist_um=np.arange(3.0))))
    assert several.batch_shape == (3,)
    stack = several.stacked_members()
    assert stack.modification_right is not None
    assert np.array_equal(stack.modification_right.twist_um, [[[0.0], [1.0], [2.0]], [[0.0]] * 3])
    assert member.modified(Modification()).modification("right") is None
    assert several.without_modifications() == builtin_design()
