"""The page of the package contains the table of statements that a run prints."""

from __future__ import annotations

from pathlib import Path

import pytest

from ..validation.statements_page import markdown

PAGE = (Path(__file__).parents[2] / "beveloid_geom/validation/README.md").read_text(encoding="utf-8")
HEADING = "## The paper, statement by statement"


@pytest.mark.slow
def test_the_page_contains_the_run() -> None:
    _, heading, after = PAGE.partition(f"\n{HEADING}\n")
    assert heading, f"the page has no section {HEADING!r}: run `python -m tests.validation.statements_page`"
    section = [line for line in after.split("\n## ")[0].splitlines() if line.startswith("|")]
    assert section == markdown().splitlines()
    assert all(line.count(" | ") == 3 for line in section)
    assert "nan" not in markdown()
