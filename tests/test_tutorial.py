"""Run the commands of the tutorial in order, and compare every number that it quotes with their output."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from beveloid_geom.cli.main import main
from beveloid_viz.cli import main as figures
from beveloid_viz.report.cli import main as report

PAGES = sorted((Path(__file__).parents[1] / "viz/site").glob("tutorial_*.md"))
PROGRAMS = {"beveloid-geom": main, "render-figures": figures, "render-report": report}
NUMBER = r"(?<![\w.])[-+]?\d+(?:\.\d+)?"
EDIT = re.compile(r"sed -i 's/\^(.*)/(.*)/' (.*)")


def numbers(line: str) -> list[str]:
    return re.findall(NUMBER, line)


def run(command: str) -> str:
    """Run a command of the tutorial, or make its change of the design file; return the output."""
    if edit := EDIT.fullmatch(command):
        file = Path(edit[3])
        changed, count = re.subn(f"(?m)^{edit[1]}", edit[2], file.read_text(encoding="utf-8"))
        assert count == 2
        file.write_text(changed, encoding="utf-8")
        return ""
    program, *arguments = shlex.split(command)
    done = CliRunner().invoke(PROGRAMS[program], arguments)
    assert done.exit_code == 0, done.output
    return done.output


def assert_quoted(quoted: list[str], output: str) -> None:
    """Assert that the numbers of each quoted line follow each other in the output, after those of the line
    before; lines without numbers must be equal."""
    printed, position = numbers(output), 0
    for line in quoted:
        if not (expected := numbers(line)):
            assert line == "..." or line in output.splitlines(), line
            continue
        places = range(position, len(printed) - len(expected) + 1)
        start = next((k for k in places if printed[k : k + len(expected)] == expected), None)
        assert start is not None, line
        position = start + len(expected)


def test_commands_and_numbers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    commands = 0
    assert len(PAGES) == 3
    for page in PAGES:
        for kind, block in re.findall(r"```(\w+)\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            if kind == "python":
                exec(compile(block, page.name, "exec"), {})
                printed = capsys.readouterr().out.split()
                assert printed == re.findall(r"# (\S+)", block)
                continue
            for entry in re.split(r"(?m)^\$ ", block)[1:]:
                command, *quoted = entry.splitlines()
                assert_quoted(quoted, run(command))
                commands += 1
    assert commands > 15
    assert {"pair.toml", "pair.stl", "tooth.inp", "pair.html", "figures"} <= {
        path.name for path in tmp_path.iterdir()
    }
