"""What the commands of pictures and pages refuse, by one contract: status 2, one line, no file."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from beveloid_viz import cli as figures
from beveloid_viz.film import cli as animation
from beveloid_viz.report import cli as report
from beveloid_viz.stage import opengl

COMMANDS = {"figures": figures.main, "animation": animation.main, "report": report.main}
REFUSED = {
    "figures": {
        "--only fig-16": "no figure named 'fig-16'",
        "--set software": "'software' is not one of 'paper', 'results', 'methods'",
        "--size 1600": "write it as 1600x1200",
        "--size 10x10": "200 to 8000 pixels",
        "--design nowhere.toml": "nowhere.toml",
        "--nonsense": "--nonsense",
        "--only fig-11 --out file/out": "cannot write to",
    },
    "animation": {
        "--out mesh.avi": "neither .gif nor .mp4",
        "--out mesh": "neither .gif nor .mp4",
        "--out mesh.gif --fps 24": "take 20 or 25, or .mp4",
        "--out mesh.gif --fps 60": "a GIF counts in hundredths",
        "--out mesh.gif --fps nan": "Invalid value for '--fps': nan is not in the range",
        "--out mesh.gif --seconds nan": "Invalid value for '--seconds': nan is not in the range",
        "--out mesh.mp4 --size 401x300": "both sides of an MP4 must be even",
        "--out mesh.gif --seconds 0.1 --fps 2": "less than 2 frames",
        "--out mesh.gif --size 9x9": "200 to 8000 pixels",
        "--out mesh.gif --offset-error x": "--offset-error",
        "--out mesh.gif --parabola-pinion 9": "--parabola-pinion",
        "--out mesh.gif nowhere.toml": "nowhere.toml",
        "--out file/mesh.gif": "cannot write to",
    },
    "report": {
        "nowhere.toml": "nowhere.toml",
        "--out nowhere/page.html": "the folder nowhere does not exist",
        "--out .": "is a directory",
        "--out page.pdf": "ends in neither .html nor .htm, which the page is: name it so",
        "--out file/page.html": "the folder file does not exist",
        "--shaft-angle-tolerance-deg 4 --offset-tolerance 300": "must be less than 60 mm on this pair",
        "--parabola-pinion 100": "--parabola-pinion must be",
        "--offset-tolerance -1": "--offset-tolerance",
        "--pinion-axial-tolerance nan": "'--pinion-axial-tolerance': nan is not in the range",
        "--cases 0": "--cases",
        "--flank left": "--flank",
    },
}


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()


def run(command: str, arguments: str) -> Result:
    return CliRunner().invoke(COMMANDS[command], arguments.split())


@pytest.mark.parametrize(
    ("command", "arguments"), [(command, one) for command, cases in REFUSED.items() for one in cases]
)
def test_bad_input_is_one_line(command: str, arguments: str) -> None:
    done = run(command, arguments)
    assert (done.exit_code, done.stdout) == (2, ""), done.output
    assert done.stderr.count("Error: ") == 1
    assert REFUSED[command][arguments] in done.stderr.splitlines()[-1]
    assert [str(path) for path in Path().rglob("*")] == ["file"]


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
