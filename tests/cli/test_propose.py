"""The command `propose`: what it prints and writes, and that it writes nothing where nothing is proposed."""

from __future__ import annotations

import csv
import io
from math import degrees, radians
from pathlib import Path

import pytest

from beveloid_geom import builtin_design
from beveloid_geom.design.file import builtin_text, parse_design, read_design
from beveloid_geom.proposal.propose import propose
from tests.cli.running import refused, run, strict_json
from tests.proposal.test_conditions import TABLE1

ASKED = (
    *("propose", "--module", "6", "--teeth", "29", "45", "--shaft-angle-deg", "15", "--offset", "229"),
    *("--helix-deg", "25", "--crossing-deg", "2.2957", "--shifts", "0.17", "0.2181", "--backlash", "0.0416"),
    *("--face-widths", "50", "60"),
)


def test_the_file_that_is_written_is_ready_for_tca(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    result = run(*ASKED, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    design = read_design(path)
    assert degrees(design.gear.helix_angle) == pytest.approx(-10.561, abs=5e-4)
    solved = run("tca", path)
    assert (solved.exit_code, solved.stderr) == (0, "")
    assert "warning" not in solved.stdout
    assert "No warnings.\n" in run("check", path).stdout


def test_json_is_the_librarys() -> None:
    data = strict_json(run(*ASKED, "--json").stdout)
    first = propose(TABLE1)[0]
    found = data["designs"][0]
    assert found["pinion_cone_angle"] == pytest.approx(float(first.design.pinion.cone_angle), abs=1e-12)
    assert found["drive_crossing_angle"] == pytest.approx(radians(2.2957), abs=1e-9)
    assert found["coast_contact_ratio"] == pytest.approx(first.figures.contact_ratio[1, 0], abs=1e-9)
    assert found["reserve"] == pytest.approx(first.figures.reserve[0], abs=1e-9)
    written = parse_design(found["toml"])
    assert float(written.gear.cone_angle) == pytest.approx(float(first.design.gear.cone_angle), abs=1e-15)
    assert data["command"].startswith("beveloid-geom propose --module 6 --teeth 29 45")


def test_csv_and_text_have_the_same(tmp_path: Path) -> None:
    data = strict_json(run(*ASKED, "--json").stdout)
    rows = list(csv.DictReader(io.StringIO(run(*ASKED, "--csv").stdout)))
    assert len(rows) == len(data["designs"])
    assert float(rows[0]["gear_helix_angle_rad"]) == data["designs"][0]["gear_helix_angle"]
    text = run(*ASKED).stdout
    assert max(map(len, text.splitlines())) <= 100
    for words in (
        "gear cone angle, deg",
        "0.8974",
        "drive crossing angle, deg",
        "2.2957",
        "the greatest reserve",
    ):
        assert words in text


def test_what_is_refused_writes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    asked = [word.replace("2.2957", "4") for word in ASKED]
    line = refused(*asked, "--out", path)
    assert "the nearest that works: --crossing-deg 3.9" in line
    assert list(tmp_path.iterdir()) == []
    assert refused(*ASKED, "--pick", "5", "--out", path).startswith("Error: --pick must be between 1 and")
    assert list(tmp_path.iterdir()) == []


def test_a_gear_that_is_given_is_held(tmp_path: Path) -> None:
    path = tmp_path / "second.toml"
    asked = ("propose", "--gear", "marine-gearbox", "--teeth", "24", "61", "--shaft-angle-deg", "7")
    result = run(*asked, "--offset", "180", "--count", "1", "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert read_design(path).gear == builtin_design("marine-gearbox").gear


def test_check_leads_with_what_to_do_and_offers_a_proposal(tmp_path: Path) -> None:
    path = tmp_path / "astray.toml"
    path.write_text(
        builtin_text().replace("shaft_angle_deg = 15.0", "shaft_angle_deg = 14.0"), encoding="utf-8"
    )
    text = run("check", path).stdout
    lines = text.splitlines()
    assert lines[1].startswith("  advice ")
    assert text.index("have a pair proposed") < text.index("  layout") < text.index("  error")
    typed = text[text.index("beveloid-geom propose") : text.index("\n  layout")]
    command = typed.replace(" \\\n", " ").split()[1:]
    assert command == strict_json(run("check", path, "--json").stdout)["proposal"].split()[1:]
    offered = run(*command, "--out", tmp_path / "mine.toml")
    assert (offered.exit_code, offered.stderr) == (0, "")
    assert "No warnings.\n" in run("check", tmp_path / "mine.toml").stdout


def test_check_prints_how_generators_cross() -> None:
    result = run("check")
    assert "cross at right 2.2957 deg, left 9.3266 deg" in result.stdout
    assert "propose" not in result.stdout
    data = strict_json(run("check", "--json").stdout)
    assert {flank: degrees(angle) for flank, angle in data["crossing"].items()} == pytest.approx(
        {"right": 2.2957, "left": 9.3266}, abs=5e-5
    )
    assert data["proposal"] is None


def test_a_pair_on_parallel_axes_passes_check(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    asked = ("propose", "--module", "3", "--teeth", "25", "31", "--shaft-angle-deg", "0")
    result = run(*asked, "--cones-deg", "3", "-3", "--count", "1", "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "drive n x  " in result.stdout
    assert "No warnings.\n" in run("check", path).stdout


def test_teeth_are_refused_first() -> None:
    line = refused("propose", "--teeth", "-25", "31")
    assert line.startswith("Error: --teeth must be at least 1, got -25: internal gears are not covered")
    assert refused("propose", "--module", "3", "--teeth", "25", "31").startswith(
        "Error: --shaft-angle-deg is"
    )
