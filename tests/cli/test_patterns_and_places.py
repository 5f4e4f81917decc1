"""Output of `pattern --over` and `place`."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import builtin_design, path_of_contact
from beveloid_geom.analysis.pattern_matrix import pattern_matrix
from tests.cli.result_cases import MODIFIED, OFFSET
from tests.cli.running import json_of, rows_of, run, strict_json, words_of

SIZES = (*OFFSET, "--shaft-angle-tolerance-deg", "0.01")
OVER = ("pattern", "--over", "offset,shaft-angle", "--resolution", "2", *MODIFIED, *SIZES)


def test_a_matrix_in_json_csv_and_text() -> None:
    found = pattern_matrix(builtin_design().with_parabola(0.001, -0.001), resolution=2.0)
    data, table, text = (run(*OVER, *form) for form in (("--json",), ("--csv",), ()))
    assert (data.exit_code, table.exit_code, text.exit_code) == (0, 0, 0)
    cells, rows = strict_json(data.stdout)["cells"], rows_of(table)
    assert strict_json(data.stdout)["trade"] == ["E", "Sigma"]
    assert [cell["status"] for cell in cells] == ["jammed"] + 8 * ["solved"]
    assert len(rows) == 18
    for k, cell in enumerate(found.cells):
        entry, both = cells[k], rows[2 * k : 2 * k + 2]
        assert [row["member"] for row in both] == ["pinion", "gear"]
        assert entry["offset_error"] == pytest.approx(found.first[k // 3])
        assert float(both[0]["shaft_angle_error_rad"]) == pytest.approx(found.second[k % 3])
        if cell is None:
            assert entry["pinion"] is None
            assert both[0]["z_mm"] == both[1]["area_mm2"] == both[0]["edge_share"] == ""
            continue
        for j, member in enumerate(("pinion", "gear")):
            ellipse = vars(cell.ellipses[j])
            assert entry[member]["ellipse"] == pytest.approx(ellipse, rel=1e-9)
            values = {name: float(both[j][f"{name}_mm"]) for name in ("z", "r", "major", "minor")}
            assert values | {"angle": float(both[j]["angle_rad"])} == pytest.approx(ellipse, rel=1e-9)
        assert entry["edge_share"] == pytest.approx(found.edge_share.flat[k], rel=1e-9)
    lines = text.stdout.splitlines()
    assert max(map(len, lines)) <= 100
    assert lines[2].split()[:6] == ["E,", "mm", "Sigma,", "deg", "TE,", "arcsec"]
    assert lines[3].split() == ["-0.05", "-0.01", "jammed"]
    assert lines[7].split()[:4] == ["0", "0", "1.8107", "18.1"]


def test_names_and_symbols_of_errors() -> None:
    tables = [
        run("pattern", "--over", over, "--resolution", "3", "--csv").stdout
        for over in ("P,g", "pinion-axial-error,gear_axial")
    ]
    assert tables[0] == tables[1]
    assert tables[0].startswith("pinion_axial_error_mm,gear_axial_error_mm,status,")


def test_the_marked_range_of_z_is_that_of_the_path_for_a_very_thin_compound() -> None:
    """Without transmission error the marked area is a narrow strip along the path of contact. The range of
    its z does not depend on the grid."""
    arguments = ("pattern", "--separation", "1e-9", "--json")
    coarse, fine = (strict_json(run(*arguments, "--resolution", size).stdout) for size in ("3", "0.8"))
    path = path_of_contact(builtin_design())
    for member in ("pinion", "gear"):
        z = getattr(path, f"{member}_z")
        assert coarse[member]["z_range"] == pytest.approx([z.min(), z.max()], abs=0.3)
        assert fine[member]["z_range"] == coarse[member]["z_range"]


def test_the_ellipse_of_a_single_pattern() -> None:
    given = "pattern", "--resolution", "2", *MODIFIED
    one = json_of(*given)["gear"]["ellipse"]
    assert f"ellipse with its centre at z {one['z']:.2f}, r {one['r']:.2f} mm" in words_of(*given)


def test_a_pair_that_jams_in_every_cell() -> None:
    result = run(*OVER, "--offset-error", "-0.5")
    assert result.exit_code == 1
    assert result.stderr == "No contact: no cell of the matrix has a pattern on the right flanks: jammed\n"


def test_a_position_without_a_mounting_has_a_note() -> None:
    result = run("place", "--by", "P,G", "--at", "25", "--at", "50", *MODIFIED)
    words = " ".join(result.stdout.split())
    assert result.exit_code == 0
    assert "note 25 %: no mounting was found within 50 mm of pinion axial and 50 mm of gear axial" in words
    assert "dw1 = " in words
    assert max(map(len, result.stdout.splitlines())) <= 100


def test_place_from_a_design_without_a_path() -> None:
    arguments = ("place", "--at", "50", "--shaft-angle-error-deg", "0.1")
    data, text = (run(*arguments, *form) for form in (("--json",), ()))
    (place,) = strict_json(data.stdout)["places"]
    assert (data.exit_code, data.stderr, text.exit_code, text.stderr) == (0, "", 0, "")
    assert place["status"] == "reached"
    assert place["shaft_angle_error"] == pytest.approx(np.radians(-0.10046), abs=1e-7)
    assert text.stdout.splitlines()[3].endswith("  reached")
    without = run("place", "--at", "50", "--offset-error", "60")
    assert without.exit_code == 1
    assert without.stdout.splitlines()[3].endswith("  no path")
    assert without.stderr == "No contact: no mounting tried has a path on the right flanks\n"


def test_place_without_a_position_that_has_values() -> None:
    jams = ("place", "awd-transfer", "--at", "75", "--pinion-modification", "helix_slope=30")
    for arguments, status, words in (
        (("place", "--at", "99.999"), 4, "Not computed: none of the positions could be computed"),
        (jams, 1, "Jammed: the pair cannot be assembled at the required positions"),
    ):
        text, data = run(*arguments), run(*arguments, "--json")
        assert (text.exit_code, data.exit_code) == (status, status)
        assert words in text.stderr
        assert strict_json(data.stdout)["reason"] in words + text.stderr
    place = strict_json(run(*jams, "--json").stdout)["places"][0]
    assert (place["status"], place["jammed"], place["z"]) == ("jammed", True, None)
    assert [row["jammed"] for row in rows_of(run(*jams, "--at", "50", "--csv"))] == ["1", "0"]
    assert run(*jams, "--at", "50").exit_code == 0  # one position has values


def test_place_where_the_pair_jams() -> None:
    data, text = (run("place", "--at", "25", *form) for form in (("--json",), ()))
    (place,) = strict_json(data.stdout)["places"]
    assert place["status"] == "off_centre"
    assert place["exact_offset_error"] == pytest.approx(-0.2547, abs=1e-3)
    assert np.isclose(place["z"], -12.5, atol=1e-6)
    words = " ".join(text.stdout.split())
    assert "25 % of the face at the required l1 needs E -0.2546" in words
    assert "the pair jams there; the nearest position at which it can be assembled is 25.0 %" in words
