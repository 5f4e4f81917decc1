"""Helpers that run the command in this process or as installed."""

from __future__ import annotations

import csv
import io
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from click import Command
from click.testing import CliRunner, Result

from beveloid_geom.cli.main import main


def run(*arguments: str | Path, program: Command = main) -> Result:
    return CliRunner().invoke(program, [str(argument) for argument in arguments])


def installed(*arguments: str | Path, program: str = "beveloid-geom") -> list[str]:
    command = shutil.which(program, path=str(Path(sys.executable).parent))
    assert command is not None, f"{program} is not installed next to the interpreter"
    return [command, *map(str, arguments)]


def call(*arguments: str | Path, program: str = "beveloid-geom") -> subprocess.CompletedProcess[str]:
    command = installed(*arguments, program=program)
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)


def refused(*arguments: str | Path, program: Command = main) -> str:
    """Return the line of a refusal, which has exit status 2."""
    result = run(*arguments, program=program)
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    assert result.stderr.startswith("Error: ")
    assert result.stderr.count("\n") == 1, result.stderr
    return result.stderr


def tca(*arguments: str | Path) -> Any:
    """Return the JSON of the command `tca`."""
    result = run("tca", "--json", *arguments)
    assert (result.exit_code, result.stderr) == (0, ""), result.stderr
    return strict_json(result.stdout)


def strict_json(text: str) -> Any:
    """Return data from strict JSON, without NaN and Infinity."""

    def refuse(name: str) -> None:
        raise AssertionError(f"{name} is not JSON")

    return json.loads(text, parse_constant=refuse)


def output_of(*arguments: str | Path, status: int = 0) -> Result:
    """Return the result of a command with this exit status. With status 0 it prints no message but notes."""
    result = run(*arguments)
    assert result.exit_code == status, result.output
    assert status or all(line.startswith("Note: ") for line in result.stderr.splitlines())
    return result


def json_of(*arguments: str | Path, status: int = 0) -> Any:
    """Return the JSON of a command."""
    return strict_json(output_of(*arguments, "--json", status=status).stdout)


def csv_of(*arguments: str | Path, status: int = 0) -> list[dict[str, str]]:
    """Return the rows of the CSV of a command."""
    return rows_of(output_of(*arguments, "--csv", status=status))


def words_of(*arguments: str | Path, status: int = 0) -> str:
    """Return the text of a command without line breaks."""
    return " ".join(output_of(*arguments, status=status).stdout.split())


def rows_of(result: Result) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(result.stdout)))


def imported_by(*arguments: str, folder: Path | None = None) -> set[str]:
    """Return the names of the modules that a command imports."""
    script = (
        "import sys\n"
        "from beveloid_geom.cli.main import main\n"
        "main(sys.argv[1:], standalone_mode=False)\n"
        "print(*sys.modules, file=sys.stderr)\n"
    )
    command = [sys.executable, "-c", script, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=folder)
    return set(done.stderr.split())
