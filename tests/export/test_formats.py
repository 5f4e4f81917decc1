"""Formats: every writer exists, and the help, messages and tables name all of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from beveloid_geom.cli.main import main
from beveloid_geom.export import CAD_FORMATS, SURFACE_FORMATS, VOLUME_FORMATS

ROOT = Path(__file__).parents[2]
ALL = {"surface": SURFACE_FORMATS, "volume": VOLUME_FORMATS, "solid": CAD_FORMATS}
each = pytest.mark.parametrize("kind", ALL)


@each
def test_help_and_messages_name_every_format(kind: str) -> None:
    help_text = CliRunner().invoke(main, ["mesh", "--help"]).stdout
    line = CliRunner().invoke(main, ["mesh", "--part", "pair", "--out", "a.pdf"]).stderr
    assert line.startswith("Error: --out: .pdf is not a known format: give one of ")
    for suffix, one in ALL[kind].items():
        assert suffix in help_text
        assert suffix in line
        assert one.purpose in " ".join(help_text.split())


@pytest.mark.parametrize("page", ["README.md", "beveloid_geom/export/README.md"])
def test_tables_name_every_format_and_its_programs(page: str) -> None:
    lines = (ROOT / page).read_text(encoding="utf-8").splitlines()
    for formats in ALL.values():
        for suffix, one in formats.items():
            if suffix == ".stp":  # another name of .step
                continue
            rows = [line for line in lines if line.startswith("| `") and f"{suffix}" in line.split("|")[1]]
            readers = " ".join(row.split("|")[3] for row in rows)
            assert all(program in readers for program in one.purpose.split(", ")), suffix
