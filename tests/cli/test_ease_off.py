"""Output of `ease-off` that is not covered by the contract in test_results."""

from __future__ import annotations

import numpy as np
import pytest

from tests.cli.result_cases import MODIFIED
from tests.cli.running import csv_of, json_of, rows_of, run, strict_json, words_of

EASE_OFF = ("ease-off", *MODIFIED, "--grid", "4", "5")


def test_csv_of_an_ease_off_has_its_points() -> None:
    rows, data = csv_of(*EASE_OFF), json_of(*EASE_OFF)
    assert len(rows) == 4 * 4 * 5
    for flank in ("right", "left"):
        for state in ("as_given", "without_parabola"):
            points = [row for row in rows if (row["flank"], row["parabola"]) == (flank, state)]
            found = data[flank][state]
            for name, unit in (("deviation", "mm"), ("pinion_roll", "rad"), ("z", "mm")):
                assert [float(row[f"{name}_{unit}"]) for row in points] == np.ravel(found[name]).tolist()
            assert {row["status"] for row in points} == {"solved"}
            places = found["profile_place"][1], found["face_place"][2]
            assert (float(points[7]["profile_place"]), float(points[7]["face_place"])) == places
            assert found["corners"]["tip_toe"] == found["deviation"][-1][0]


def test_text_of_an_ease_off_is_in_um() -> None:
    text, data = run(*EASE_OFF).stdout, json_of(*EASE_OFF)
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
    found = strict_json(data.stdout)
    reason = found["reason"]
    assert reason.startswith("the path of contact does not meet the right flanks")
    assert text.stderr == table.stderr == f"No contact: {reason}\n"
    assert found["right"]["as_given"]["reason"] == reason
    assert {row["flank"] for row in rows_of(table)} == {"left"}
    assert f"note right flanks, as designed: {reason}" in " ".join(text.stdout.split())
    none = run("ease-off", "--offset-error", "30", "--csv")
    assert (none.exit_code, none.stdout.count("\n")) == (1, 1)
    assert none.stdout.startswith("flank,parabola,profile_place")


def test_points_of_an_ease_off_without_a_conjugate_are_empty() -> None:
    given = ("ease-off", "--parabola-pinion=-0.002", "--parabola-gear", "0.003", "--grid", "3", "5")
    lost = [row for row in csv_of(*given) if row["status"] != "solved"]
    assert {row["status"] for row in lost} == {"not_converged"}
    assert {row["deviation_mm"] + row["pinion_roll_rad"] for row in lost} == {""}
    words = words_of(*given)
    assert f"right flanks, as designed: the mate has no conjugate at {len(lost)} of 15 points" in words
    assert "nan" not in words
