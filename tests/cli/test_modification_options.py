"""Options for the modification of a member: the same design as with a table in a file."""

from __future__ import annotations

from pathlib import Path

import pytest

from beveloid_geom.design.amounts import amounts_text, read_amounts
from beveloid_geom.design.file import builtin_text
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


def test_options_replace_the_tables_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "pair.toml"
    file.write_text(builtin_text() + TABLES, encoding="utf-8")
    sliding = "sliding", "--csv", "--points", "2"
    expected = run(*sliding, file)
    assert expected.exit_code == 0
    assert run(*sliding, *OPTIONS).stdout == expected.stdout
    none = run(*sliding, file, "--pinion-modification", "none", "--gear-modification", "none").stdout
    assert none == run(*sliding).stdout != expected.stdout


@pytest.mark.parametrize(
    ("amounts", "message"),
    [
        ("", "cannot be read at ''"),
        ("helix_crowning", "cannot be read at 'helix_crowning'"),
        ("twist=1, twist_um=2", "has twist_um twice"),
        ("twist=1e6", "twist_um must be between -100000 and 100000 um, got 1000000.0"),
        ("right.twist=5um", "right.twist_um must be a number, got '5um': give it in um without a unit, 5"),
        ("helix_crownin=5", "helix_crownin is unknown: did you mean helix_crowning_um?"),
        ("tip_relief=5", "tip_relief_um needs tip_relief_length_mm"),
        ("both.twist=5", "both is unknown: tables for one flank are right and left"),
    ],
)
def test_refusals(amounts: str, message: str) -> None:
    line = refused("check", "--gear-modification", amounts)
    assert line.startswith(f"Error: --gear-modification {message}")


def test_amounts_as_text() -> None:
    """Amounts that were read are written as a text with the same meaning."""
    for text in ("none", "helix_crowning=10.0, right.tip_relief=5.0, right.tip_relief_length=2.0"):
        assert amounts_text(read_amounts(text)) == text
