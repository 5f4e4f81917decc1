"""Options for the modification of a member: the same design as with a table in a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from beveloid_geom.design.amounts import amounts_text, read_amounts
from tests.cli.running import refused, run

TABLES = """
[pinion.modification]
helix_crowning_um = 10.0
[pinion.modification.left]
tip_relief_um = 15.0
tip_relief_length_mm = 2.5
[gear.modification]
profile_slope_um = -4.0
"""
OPTIONS = (
    *("--pinion-modification", "lead_crowning=10, left.tip_relief=15, left.tip_relief_length_mm=2.5"),
    *("--gear-modification", "profile_slope_um = -4"),
)


def test_options_replace_the_tables_of_a_file(design_file: Callable[..., Path]) -> None:
    file = design_file(more=TABLES)
    sliding = "sliding", "--csv", "--points", "2"
    expected = run(*sliding, file)
    assert expected.exit_code == 0
    assert run(*sliding, *OPTIONS).stdout == expected.stdout
    none = run(*sliding, file, "--pinion-modification", "none", "--gear-modification", "none").stdout
    assert none == run(*sliding).stdout != expected.stdout


def test_refused_names_of_the_option() -> None:
    """Keys that only a design file may have are not suggested, with or without their unit."""
    option = "--pinion-modification"
    for name in ("pitch_deviations", "pitch_deviations_um"):
        cure = "can only be given in a design file: write it in [pinion.modification]"
        assert refused("check", option, f"{name}=3") == f"Error: {option} pitch_deviations_um {cure}\n"
    line = refused("check", option, "foo=1")
    assert line.startswith(f"Error: {option} foo is unknown: known are helix_slope_um,")
    assert "deviations" not in line
    assert run("sliding", option, "NONE").stdout == run("sliding", option, "none").stdout != ""


def test_refused_lengths_name_the_option() -> None:
    lengths = "tip_relief=10, tip_relief_length=100"
    for flank in ("", "right."):
        given = lengths.replace("tip_relief", f"{flank}tip_relief")
        line = refused("check", "--gear-modification", given)
        assert line.startswith(f"Error: --gear-modification {flank}tip_relief_length_mm must be at most ")


def test_amounts_as_text() -> None:
    """Amounts that were read are written as a text with the same meaning."""
    for text in ("none", "helix_crowning=10.0, right.tip_relief=5.0, right.tip_relief_length=2.0"):
        assert amounts_text(read_amounts(text)) == text
