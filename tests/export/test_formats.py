"""Formats: the tables of the documentation name all of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from beveloid_geom.export import CAD_FORMATS, SURFACE_FORMATS, VOLUME_FORMATS

ROOT = Path(__file__).parents[2]
ALL = (SURFACE_FORMATS, VOLUME_FORMATS, CAD_FORMATS)


@pytest.mark.parametrize("page", ["README.md", "beveloid_geom/export/README.md"])
def test_tables_name_every_format_and_its_programs(page: str) -> None:
    lines = (ROOT / page).read_text(encoding="utf-8").splitlines()
    for formats in ALL:
        for suffix, one in formats.items():
            if suffix == ".stp":  # another name of .step
                continue
            rows = [line for line in lines if line.startswith("| `") and f"{suffix}" in line.split("|")[1]]
            readers = " ".join(row.split("|")[3] for row in rows)
            assert all(program in readers for program in one.purpose.split(", ")), suffix
