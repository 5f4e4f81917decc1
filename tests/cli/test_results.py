"""Contract of all commands that print a result.

JSON has the values of the library, CSV those of JSON, and the text has at most 100 columns. A missing result
has one line on standard error and an exit status."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from beveloid_geom import builtin_design
from beveloid_geom.cli.main import main
from tests.cli.result_cases import CASES, printed
from tests.cli.running import rows_of, run, strict_json

SLOW = {"modify"}
by_command = pytest.mark.parametrize(
    "command", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in CASES]
)


def at(data: Any, place: str) -> Any:
    """Return the entry of JSON at a place such as path/l1."""
    for key in place.split("/"):
        data = data[int(key) if isinstance(data, list) else key]
    return data


def test_all_commands_have_a_case() -> None:
    assert set(CASES) == set(main.commands) - {"design", "mesh", "propose"}


@by_command
def test_json_has_the_library_values(command: str) -> None:
    data = strict_json(printed(command, "json").stdout)
    expected = CASES[command].library(builtin_design().with_parabola(0.001, -0.001))
    for place, value in expected.items():
        entry = at(data, place)
        if isinstance(value, str | list | dict | None):
            assert entry == value, place
        else:
            np.testing.assert_allclose(np.array(entry, float), value, rtol=1e-9, atol=1e-12, err_msg=place)


@by_command
def test_csv_has_the_json_values(command: str) -> None:
    rows, data = rows_of(printed(command, "csv")), strict_json(printed(command, "json").stdout)
    assert rows
    for header, place in CASES[command].columns.items():
        values = np.ravel(at(data, place)).tolist()
        assert [row[header] for row in rows] == ["" if v is None else str(v) for v in values], header


@by_command
def test_text(command: str) -> None:
    text = printed(command).stdout
    assert max(map(len, text.splitlines())) <= 100
    assert "nan" not in text.replace("nance", "")
    assert all(words in " ".join(text.split()) for words in CASES[command].words)


@pytest.mark.parametrize("command", [name for name, case in CASES.items() if case.lost])
def test_missing_result(command: str) -> None:
    """JSON contains the reason for a missing result; the other forms print it on standard error."""
    case = CASES[command]
    text, rows, data = (
        run(command, *case.arguments, *case.lost, *form) for form in ((), ("--csv",), ("--json",))
    )
    assert (text.exit_code, rows.exit_code, data.exit_code) == (1, 1, 1)
    assert text.stderr == rows.stderr
    assert text.stderr.startswith(f"No contact: {case.why}")
    reason = {"sensitivity": case.why}.get(command) or strict_json(data.stdout)["reason"]
    assert (data.stderr, text.stderr) == ("", f"No contact: {reason}\n")
    if command != "map":
        assert strict_json(data.stdout)["contact_ratio"] in (0.0, None) or command == "operation"
    if command in ("tca", "sliding", "sensitivity"):
        assert rows.stdout.count("\n") == 1


@pytest.mark.parametrize("command", ["tca", "operation", "sensitivity", "pattern"])
def test_jammed_pair(command: str) -> None:
    """A mounting error larger than the backlash gives a negative backlash, no certificate, and exit status
    1."""
    few = {"pattern": ("--resolution", "2"), "operation": ("--points", "3")}
    given = ("--offset-error", "-0.5", *few.get(command, ()))
    result, data, table = (run(command, *given, *form) for form in ((), ("--json",), ("--csv",)))
    words, entries = " ".join(result.stdout.split()), strict_json(data.stdout)
    assert "backlash -0.313020 mm with errors and modifications" in words
    assert "the pair cannot be assembled" in words
    assert result.stderr.startswith("Jammed: the pair cannot be assembled: the flanks of one side interfere")
    assert (result.exit_code, table.exit_code, data.exit_code, data.stderr) == (1, 1, 1, "")
    assert entries["jammed"] is True
    assert "certificate" not in entries
    assert entries["normal_backlash"] == pytest.approx(0.0416, abs=5e-5)
    assert entries["mounted_backlash"]["normal"] == pytest.approx(-0.3130, abs=5e-5)
    assert entries["mounted_backlash"]["left"]["edges"] == []
    backlash = {row["mounted_backlash_mm"] for row in rows_of(table) if "mounted_backlash_mm" in row}
    assert {float(value) for value in backlash} <= {entries["mounted_backlash"]["normal"]}
