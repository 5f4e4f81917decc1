"""Commands that draw, without OpenGL."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from beveloid_viz import cli as figures
from beveloid_viz.film import cli as animation
from beveloid_viz.rendering import opengl
from beveloid_viz.report import cli as report

COMMANDS = {"figures": figures.main, "animation": animation.main, "report": report.main}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()


def run(command: str, arguments: str) -> Result:
    return CliRunner().invoke(COMMANDS[command], arguments.split())


@pytest.mark.parametrize(
    ("command", "arguments"), [("figures", "--only fig-09"), ("animation", "--out a.gif")]
)
def test_without_opengl_the_package_is_named(
    command: str, arguments: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(opengl, "draws", lambda _: False)
    monkeypatch.delenv(opengl.VARIABLE, raising=False)
    done = run(command, arguments)
    assert done.exit_code == 3
    assert "sudo apt-get install libosmesa6" in done.stderr
    assert [str(path) for path in Path().rglob("*")] == ["file"]
