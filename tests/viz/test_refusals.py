"""Bad input of the commands that draw, and machines without OpenGL."""

from __future__ import annotations

from pathlib import Path

import pytest

from beveloid_viz import cli as figures
from beveloid_viz.film import cli as animation
from beveloid_viz.rendering import opengl
from beveloid_viz.report import cli as report
from tests.cli.running import refused, run

PROGRAMS = {"figures": figures.main, "animation": animation.main, "report": report.main}
DRAWINGS = {
    "figures": {
        "--width-mm 90 --size 800x600": "--size and --width-mm cannot both be given",
        "--width-mm 70": "80<=x<=260",
        "--width-mm wide": "'wide' is not a number",
        "--format bmp": "'bmp' is not one of 'png', 'pdf', 'svg'",
        "--only fig-16": "no figure named 'fig-16'",
        "--set software": "'software' is not one of 'paper', 'results', 'methods'",
        "--size 1600": "write it as 1600x1200",
        "--size 10x10": "200 to 8000 pixels",
        "--design nowhere.toml": "nowhere.toml",
        "--nonsense": "--nonsense",
        "--only fig-11 --out file/out": "cannot write to",
        **{
            f"--only fig-02 {given}": f"{given.split()[0]} has no effect without --measured: add --measured,"
            for given in ("--member gear", "--rows 5", "--columns 9", "--border 5%")
        },
    },
    "animation": {
        "--out mesh.avi": "neither .gif nor .mp4",
        "--out mesh": "neither .gif nor .mp4",
        "--out mesh.gif --fps 24": "choose 20 or 25, or write .mp4",
        "--out mesh.gif --fps 60": "choose 50, or write .mp4",
        "--out mesh.gif --fps nan": "Invalid value for '--fps': nan is not in the range",
        "--out mesh.gif --seconds nan": "Invalid value for '--seconds': nan is not in the range",
        "--out mesh.mp4 --size 401x300": "both sides of an MP4 must be even",
        "--out mesh.gif --seconds 0.1 --fps 2": "fewer than 2 frames",
        "--out mesh.gif --size 9x9": "200 to 8000 pixels",
        "--out mesh.gif --offset-error x": "--offset-error",
        "--out mesh.gif --parabola-pinion 9": "--parabola-pinion",
        "--out mesh.gif nowhere.toml": "nowhere.toml",
        "--out file/mesh.gif": "--out: the folder file does not exist: create it first",
        "--out nowhere/mesh.gif": "--out: the folder nowhere does not exist: create it first",
    },
    "report": {
        "nowhere.toml": "nowhere.toml",
        "--out nowhere/page.html": "the folder nowhere does not exist",
        "--out .": "is a directory",
        "--out page.pdf": "ends in neither .html nor .htm: choose such a name",
        "--out file/page.html": "the folder file does not exist",
        "--shaft-angle-tolerance-deg 4 --offset-tolerance 300": "must be less than 60 mm on this pair",
        "--parabola-pinion 100": "--parabola-pinion must be",
        "--offset-tolerance -1": "--offset-tolerance",
        "--offset-tolerance 0.1 --in-plane-tolerance-deg 0.1": (
            "--offset-tolerance is about the common perpendicular, but --in-plane"
        ),
        "--offset-tolerance 0": "at least one tolerance must be above 0, got 0 for --offset-tolerance: omit",
        "--offset-tolerance 100": "--offset-tolerance must be less than 60 mm on this pair",
        "--pinion-axial-tolerance nan": "'--pinion-axial-tolerance': nan is not in the range",
        "--cases 0": "--cases",
        "--flank left": "--flank",
    },
}
"""Part of the expected line by program and options."""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()


@pytest.mark.parametrize(
    ("program", "options", "words"),
    [(program, options, words) for program, cases in DRAWINGS.items() for options, words in cases.items()],
)
def test_bad_input(program: str, options: str, words: str) -> None:
    assert words in refused(*options.split(), program=PROGRAMS[program])
    assert [str(path) for path in Path().rglob("*")] == ["file"]


@pytest.mark.parametrize(
    ("command", "arguments"), [("figures", "--only fig-09"), ("animation", "--out a.gif")]
)
def test_without_opengl_the_package_is_named(
    command: str, arguments: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(opengl, "draws", lambda _: False)
    monkeypatch.delenv(opengl.VARIABLE, raising=False)
    done = run(*arguments.split(), program=PROGRAMS[command])
    assert done.exit_code == 3
    assert "sudo apt-get install libosmesa6" in done.stderr
    assert [str(path) for path in Path().rglob("*")] == ["file"]
