"""Output and files of the command `propose`."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, radians
from pathlib import Path

import pytest

from beveloid_geom import builtin_design, contact_ratio, read_design
from beveloid_geom.design.file import parse_design
from beveloid_geom.pair.generator_angle import generator_angle_as_mounted
from beveloid_geom.proposal.propose import propose
from tests.cli.running import csv_of, json_of, refused, run, strict_json, words_of
from tests.proposal.test_closure_equations import TABLE1

REQUEST = (
    *("propose", "--module", "6", "--teeth", "29", "45", "--shaft-angle-deg", "15", "--offset", "229"),
    *("--helix-deg", "25", "--crossing-deg", "2.2957", "--shifts", "0.17", "0.2181", "--backlash", "0.0416"),
    *("--face-widths", "50", "60"),
)


def test_written_file_is_accepted_by_tca(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    result = run(*REQUEST, "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    design = read_design(path)
    assert degrees(design.gear.helix_angle) == pytest.approx(-10.561, abs=5e-4)
    solved = run("tca", path)
    assert (solved.exit_code, solved.stderr) == (0, "")
    assert "warning" not in solved.stdout
    assert "No warnings.\n" in run("check", path).stdout


def test_json_has_the_library_values() -> None:
    data = json_of(*REQUEST)
    first = propose(TABLE1)[0]
    entry = data["designs"][0]
    assert entry["pinion_cone_angle"] == pytest.approx(float(first.design.pinion.cone_angle), abs=1e-5)
    assert entry["drive_crossing_angle"] == pytest.approx(radians(2.2957), abs=1e-5)
    assert entry["coast_contact_ratio"] == pytest.approx(first.criteria.contact_ratio[1, 0], abs=1e-3)
    assert entry["coast_n_x"] == pytest.approx(first.criteria.normal_x[1, 0], abs=1e-5)
    assert entry["gear_undercut_margin"] == pytest.approx(first.criteria.margin[1, 0], abs=1e-4)
    assert entry["reserve"] == pytest.approx(first.criteria.reserve[0], abs=1e-9)
    written = parse_design(entry["toml"])
    for side, flank in (("drive", "right"), ("coast", "left")):
        angle = float(generator_angle_as_mounted(written, flank))
        assert entry[f"{side}_crossing_angle"] == pytest.approx(angle, abs=1e-12)
        ratio = float(contact_ratio(written, flank))
        assert entry[f"{side}_contact_ratio"] == pytest.approx(ratio, abs=1e-12)
    assert float(written.gear.cone_angle) == pytest.approx(entry["gear_cone_angle"], abs=1e-15)
    assert data["command"].startswith("beveloid-geom propose --module 6 --teeth 29 45")


def test_csv_and_text(tmp_path: Path) -> None:
    data = json_of(*REQUEST)
    rows = csv_of(*REQUEST)
    assert len(rows) == len(data["designs"])
    assert float(rows[0]["gear_helix_angle_rad"]) == data["designs"][0]["gear_helix_angle"]
    text = run(*REQUEST).stdout
    assert max(map(len, text.splitlines())) <= 100
    for words in ("gear cone angle, deg", "0.8974", "drive crossing angle, deg", "2.2957", "largest reserve"):
        assert words in text


def test_refusal_writes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    request = [word.replace("2.2957", "4") for word in REQUEST]
    line = refused(*request, "--out", path)
    assert "the nearest request with a solution: --crossing-deg 3.9" in line
    assert list(tmp_path.iterdir()) == []
    assert refused(*REQUEST, "--pick", "5", "--out", path).startswith("Error: --pick must be between 1 and")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--backlash", "-1"), "--backlash must be between 0 and 6 mm, got -1.0: it is the normal backlash"),
        (("--shifts", "5", "5"), "--shifts must be between -3 and 3, got 5.0"),
        (("--cone-limits-deg", "10", "1"), "--cone-limits-deg must have the lower limit first, got 10 1"),
    ],
)
def test_refused_values_are_as_written_and_in_one_line(options: tuple[str, ...], message: str) -> None:
    assert refused(*REQUEST, *options).startswith(f"Error: {message}")


def test_given_gear_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "second.toml"
    request = ("propose", "--gear", "marine-gearbox", "--teeth", "24", "61", "--shaft-angle-deg", "7")
    result = run(*request, "--offset", "180", "--count", "1", "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert read_design(path).gear == builtin_design("marine-gearbox").gear


def test_default_is_least_cones() -> None:
    """Without given cone angles, the first proposal has the smallest cones, and no steep helix angle."""
    for shaft in ("0", "20", "60"):
        request = ("propose", "--module", "4", "--teeth", "25", "31", "--shaft-angle-deg", shaft)
        data = json_of(*request)
        assert data["command"].endswith("--least-cones")
        first = data["designs"][0]
        assert max(abs(first["pinion_cone_angle"]), abs(first["gear_cone_angle"])) < radians(0.01)
        steepest = max(abs(degrees(first[f"{name}_helix_angle"])) for name in ("pinion", "gear"))
        assert steepest <= max(31.0, 0.5 * float(shaft) + 5.0)


def test_steep_helix_angles_come_last_on_parallel_axes() -> None:
    request = ("propose", "--module", "2", "--teeth", "20", "50", "--shaft-angle-deg", "0")
    designs = json_of(*request, "--cones-deg", "5", "-5")["designs"]
    assert all(abs(degrees(one["pinion_helix_angle"])) < 31.0 for one in designs)


def test_file_is_not_replaced_without_overwrite(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    result = run(*REQUEST, "--out", path)
    assert result.stdout.startswith(f"{path}: proposal 1 of 1, module 6 mm, teeth 29/45, helix 25/-10.56 deg")
    written = path.read_text(encoding="utf-8")
    assert refused(*REQUEST, "--out", path).endswith(
        "exists already: add --overwrite, or choose another --out\n"
    )
    assert path.read_text(encoding="utf-8") == written
    again = run(*REQUEST, "--json", "--out", path, "--overwrite")
    assert again.exit_code == 0
    assert again.stderr.startswith(f"{path}: proposal 1 of 1")
    assert strict_json(again.stdout)["designs"][0]["toml"] == written


def test_tips_that_are_nowhere_in_mesh_have_a_negative_reserve() -> None:
    """At 90 deg, points of the tip edges are in mesh at no roll: the reserve is negative."""
    text = words_of("propose", "--module", "3", "--teeth", "13", "44", "--shaft-angle-deg", "90")
    assert "pair 1: the tips have points that are nowhere in mesh with the mate" in text
    assert "reserve negative" in text
    assert "inf" not in text


def test_weakest_criterion(tmp_path: Path) -> None:
    """The criterion with the smallest reserve is printed: in an intersecting pair with wide faces, tips reach
    deep away from the path, and the reserve is negative."""
    request = (
        *("propose", "--module", "8", "--teeth", "24", "27", "--face-widths", "70.3173", "70.3173"),
        *("--shaft-angle-deg", "16.5152", "--offset", "0", "--backlash", "0.229664", "--least-cones"),
    )
    data, text = json_of(*request), words_of(*request)
    first = data["designs"][0]
    assert first["weakest"] == "depth of tips"
    assert first["reserve"] < 0.0
    assert "smallest reserve depth of tips (pair 1)" in text
    depth = -0.1 * 8.0 * first["reserve"]
    assert f"pair 1: the tips reach {depth:.3g} mm below the mate's active flank (form diameter)" in text
    path = tmp_path / "mine.toml"
    run(*request, "--out", path)
    notes = json_of("check", path)["notes"]
    assert any("form diameter" in note for note in notes)


def test_check_prints_advice_first_and_a_proposal(tmp_path: Path, design_file: Callable[..., Path]) -> None:
    path = design_file({"shaft_angle_deg = 15.0": "shaft_angle_deg = 14.0"})
    text = run("check", path).stdout
    lines = text.splitlines()
    assert lines[1].startswith("  advice ")
    assert text.index("propose a pair") < text.index("  layout") < text.index("  error")
    typed = text[text.index("beveloid-geom propose") : text.index("\n  layout")]
    command = typed.replace(" \\\n", " ").split()[1:]
    assert command == json_of("check", path, status=1)["proposal"].split()[1:]
    offered = run(*command, "--out", tmp_path / "mine.toml")
    assert (offered.exit_code, offered.stderr) == (0, "")
    assert "No warnings.\n" in run("check", tmp_path / "mine.toml").stdout


def test_check_prints_the_angle_between_generators() -> None:
    words, data = words_of("check"), json_of("check")
    assert (
        "crossing angle between the generators of the flanks: 2.2957 deg (right), 9.3266 deg (left)" in words
    )
    assert "propose" not in words
    found = {flank: degrees(angle) for flank, angle in data["crossing"].items()}
    assert found == pytest.approx({"right": 2.2957, "left": 9.3266}, abs=5e-5)
    assert data["proposal"] is None


def test_a_pair_on_parallel_axes_passes_check(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    request = ("propose", "--module", "3", "--teeth", "25", "31", "--shaft-angle-deg", "0")
    result = run(*request, "--cones-deg", "3", "-3", "--count", "1", "--out", path)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "drive n_x  " in result.stdout
    assert "No warnings.\n" in run("check", path).stdout
