"""Output of `ease-off` that is not covered by the contract in test_results."""

from __future__ import annotations

import numpy as np
import pytest

from tests.cli.result_cases import MODIFIED
from tests.cli.running import rows_of, run, strict_json

EASE_OFF = ("ease-off", *MODIFIED, "--grid", "4", "5")


def test_csv_of_an_ease_off_has_its_points() -> None:
    rows, data = rows_of(run(*EASE_OFF, "--csv")), strict_json(run(*EASE_OFF, "--json").stdout)
    assert len(rows) == 4 * 4 * 5
    for flank in ("right", "left"):
        for state in ("as_given", "without_parabola"):
            points = [row for row in rows if (row["flank"], row["parabola"]) == (flank, state)]
            found = data[flank][state]
            for header, name in (
                ("deviation_mm", "deviation"),
                ("pinion_roll_rad", "pinion_roll"),
                ("z_mm", "z"),
            ):
                assert [float(row[header]) for row in points] == np.ravel(found[name]).tolist()
            assert {row["status"] for row in points} == {"solved"}
            places = found["profile_place"][1], found["face_place"][2]
            assert (float(points[7]["profile_place"]), float(points[7]["face_place"])) == places
            assert found["corners"]["tip_toe"] == found["deviation"][-1][0]


def test_text_of_an_ease_off_is_in_um() -> None:
    text, data = run(*EASE_OFF).stdout, strict_json(run(*EASE_OFF, "--json").stdout)
    for words, group, name in (
        ("root, heel", "corners", "root_heel"),
        ("twist", "second_order", "twist"),
        ("rms of the residual", "second_order", "rest"),
    ):
        (line,) = (line for line in text.splitlines() if line.strip().startswith(words))
        wanted = [
            data[f][s][group][name] for f in ("right", "left") for s in ("as_given", "without_parabola")
        ]
        found = [float(word) for word in line.split(words)[1].split()]
        assert found == pytest.approx(1e3 * np.array(wanted), abs=5.1e-4)
    assert "unmodified" not in run("ease-off", "--grid", "3", "3").stdout
    crowned = run("ease-off", "--grid", "3", "3", "--pinion-modification", "helix_crowning=10").stdout
    assert crowned.count("unmodified") == 3  # two columns and the definition


def test_an_ease_off_without_a_path_on_one_flank() -> None:
    """The other flank has a path; the flank without parabolas is reported separately."""
    text, data, table = (
        run("ease-off", "--offset-error", "5", "--grid", "3", "3", *f) for f in ((), ("--json",), ("--csv",))
    )
    assert (text.exit_code, data.exit_code, table.exit_code, data.stderr) == (1, 1, 1, "")
    assert text.stderr == table.stderr
    assert text.stderr.startswith("No contact: the path of contact does not meet the right flanks")
    assert text.stderr.count("\n") == 1
    found = strict_json(data.stdout)
    assert (
        found["reason"]
        == found["right"]["as_given"]["reason"]
        == text.stderr.removeprefix("No contact: ")[:-1]
    )
    assert {row["flank"] for row in rows_of(table)} == {"left"}
    assert "note right flanks, as designed: the path of contact does not meet" in " ".join(
        text.stdout.split()
    )
    none = run("ease-off", "--offset-error", "30", "--csv")
    assert (none.exit_code, none.stdout.count("\n")) == (1, 1)
    assert none.stdout.startswith("flank,parabola,profile_place")


def test_points_of_an_ease_off_without_a_conjugate_are_empty() -> None:
    given = ("ease-off", "--parabola-pinion=-0.002", "--parabola-gear", "0.003", "--grid", "3", "5")
    lost = [row for row in rows_of(run(*given, "--csv")) if row["status"] != "solved"]
    assert [(row["status"], row["deviation_mm"], row["pinion_roll_rad"]) for row in lost] == [
        ("not_converged", "", "")
    ] * len(lost)
    words = " ".join(run(*given).stdout.split())
    assert f"right flanks, as designed: the mate has no conjugate at {len(lost)} of 15 points" in words
    assert "nan" not in words
