"""The command `render-figures`: what it writes, what it refuses, and a machine without OpenGL."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from matplotlib.image import imread

from beveloid_geom import builtin_design
from beveloid_geom.design.file import builtin_text
from beveloid_viz.cli import chosen_figures, main
from beveloid_viz.figures import FIGURES
from beveloid_viz.stage import opengl

from ..symmetry import scaled

COMMAND = Path(sys.executable).with_name("render-figures")


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([COMMAND, *arguments], capture_output=True, text=True, check=False)


def test_figures_are_written_with_their_numbers(tmp_path: Path) -> None:
    out = tmp_path / "new" / "figures"
    done = run("--only", "fig-07", "--only", "fig-11", "--out", str(out), "--size", "640x480")
    assert done.returncode == 0, done.stderr
    assert str(out) in done.stdout
    assert "triangles" in done.stdout
    assert sorted(p.name for p in out.iterdir()) == ["fig-07.csv", "fig-07.png", "fig-11.csv", "fig-11.png"]
    assert imread(out / "fig-07.png").shape[:2] == (480, 640)
    with open(out / "fig-07.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["member"] for row in rows} == {"pinion", "gear"}
    path = [row for row in rows if row["index"]]
    assert {row["status"] for row in path} == {"solved"}
    assert len(path) == 5 * 2 * 101
    rest = [row for row in rows if not row["index"]]  # the other rolls of a pitch, where Eq. 16 is below 1
    assert {row["status"] for row in rest} == {"off_flank"}
    assert all(float(row["contact_ratio"]) < 1.0 and row["edge_that_touches"] for row in rest)
    straight = next(row for row in rows if float(row["a1_per_mm"]) == 0.0)
    assert float(straight["contact_ratio"]) == pytest.approx(1.651001, abs=1e-6)


def test_processes_write_what_one_writes(tmp_path: Path) -> None:
    arguments = ["--only", "fig-02", "--only", "fig-11", "--size", "320x240", "--out"]
    for jobs in ("1", "2"):
        done = run(*arguments, str(tmp_path / jobs), "--jobs", jobs)
        assert done.returncode == 0, done.stderr
        names = [line.split()[0] for line in done.stdout.splitlines()]
        assert names[:2] == ["fig-02", "fig-11"]
    for name in ("fig-02.csv", "fig-02.png", "fig-11.csv", "fig-11.png"):
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "2" / name).read_bytes()


def test_a_process_that_is_killed_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("beveloid_viz.cli.make_figure", abort)
    done = CliRunner().invoke(
        main, ["--only", "fig-02", "--only", "fig-11", "--jobs", "2", "--out", str(tmp_path)]
    )
    assert done.exit_code == 2
    assert "--jobs 1" in done.stderr
    assert list(tmp_path.iterdir()) == []


def abort(*_: object) -> None:
    """Stands for a process that the system kills."""
    os.abort()


def test_figures_of_time_are_made_last_and_alone() -> None:
    assert [figure.name for figure in FIGURES if figure.timed] == ["speed-accuracy"]


PAPER = [f"fig-{k:02d}" for k in range(1, 16)]
RESULTS = [
    "separation",
    "pattern",
    "pattern-errors",
    "transmission-error",
    "statements",
    "ease-off",
    "sliding",
    "sensitivity",
    "tolerance-cloud",
    "map-parabola",
    "map-mounting",
    "posed-pair",
    "meshed-tooth",
]
METHODS = ["mesh-convergence", "speed-accuracy"]


def test_list_names_the_figures_and_their_sets() -> None:
    done = run("--list")
    assert done.returncode == 0
    names = [(name, "paper") for name in PAPER]
    names += [(name, "results") for name in RESULTS] + [(name, "methods") for name in METHODS]
    assert [tuple(line.split()[:2]) for line in done.stdout.splitlines()] == names
    assert [(figure.name, figure.set) for figure in FIGURES] == names


@pytest.mark.parametrize(
    ("names", "sets", "chosen"),
    [
        ((), (), PAPER + RESULTS),
        ((), ("methods",), METHODS),
        (("speed-accuracy", "fig-02"), (), ["fig-02", "speed-accuracy"]),
        (("fig-02",), ("methods",), ["fig-02", *METHODS]),
    ],
)
def test_figures_are_chosen_by_name_and_set(
    names: tuple[str, ...], sets: tuple[str, ...], chosen: list[str]
) -> None:
    assert [figure.name for figure in chosen_figures(names, sets)] == chosen


def test_both_flanks_are_drawn(tmp_path: Path) -> None:
    """The left flanks of a pair are the right ones of its mirror image; figures of both are drawn once."""
    mirror = tmp_path / "mirror.toml"
    text = builtin_text().replace("helix_angle_deg = 25.0", "helix_angle_deg = -25.0")
    mirror.write_text(text.replace("helix_angle_deg = -10.57", "helix_angle_deg = 10.57"))
    for design, flank in (("ni-2017", "both"), (str(mirror), "right")):
        only = ["--only", "fig-09", "--only", "fig-11", "--size", "320x240", "--jobs", "1"]
        done = run(*only, "--design", design, "--flank", flank, "--out", str(tmp_path / flank))
        assert done.returncode == 0, done.stderr
    names = sorted(path.stem for path in (tmp_path / "both").glob("*.png"))
    assert names == ["fig-09", "fig-09-left", "fig-11"]
    left, right = (
        list(csv.DictReader((tmp_path / folder).read_text(encoding="utf-8").splitlines()))
        for folder in ("both/fig-09-left.csv", "right/fig-09.csv")
    )
    assert len(left) == len(right) > 1000
    for one, other in zip(left, right, strict=True):
        for name in ("contact_ratio", "z_mm", "r_mm", "length_mm", "operating_contact_ratio"):
            assert float(one[name]) == pytest.approx(float(other[name]), abs=1e-9)


def test_coefficients_and_errors_scale_with_the_module() -> None:
    """Figures of a pair a third as large have three times the coefficients and a third of the errors."""
    small = scaled(builtin_design(), 1.0 / 3.0)
    for name, times in (("fig-09", 3.0), ("fig-12", 1.0 / 3.0)):
        recipe = next(figure for figure in FIGURES if figure.name == name).recipe()
        (header, own), (_, usual) = (
            recipe.rows(recipe.compute(design)) for design in (small, builtin_design())
        )
        column = list(header).index("a1_per_mm" if name == "fig-09" else "offset_error_mm")
        greatest, expected = (max(float(str(row[column])) for row in rows) for rows in (own, usual))
        assert greatest == pytest.approx(times * expected, rel=0.03)  # to two digits


def test_a_faulty_design_names_every_fault(tmp_path: Path) -> None:
    design = tmp_path / "design.toml"
    design.write_text(
        builtin_text().replace("teeth = 29", "teeth = 0").replace("offset = 229.0", "offset = nan")
    )
    done = CliRunner().invoke(main, ["--design", str(design), "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "[pinion] teeth" in done.stderr
    assert "[pair] offset" in done.stderr


def test_an_interrupted_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    done = CliRunner().invoke(main, ["--only", "fig-11", "--out", str(tmp_path), "--size", "400x300"])
    assert done.exit_code == 2
    assert "No space left on device" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_window_class_that_crashes_is_not_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The probe's child process may die; the program does not."""
    monkeypatch.setattr(opengl, "PROBE", "import os; os.abort()")
    assert not opengl.draws("")


def test_window_classes() -> None:
    assert list(opengl.window_classes({opengl.VARIABLE: "mine", "DISPLAY": ":0"})) == ["mine"]
    assert list(opengl.window_classes({}, "darwin")) == [""]
    assert "" not in list(opengl.window_classes({}, "linux"))
    assert next(opengl.window_classes({"DISPLAY": ":0"}, "linux")) == ""


@pytest.mark.slow
def test_a_design_without_contact_is_drawn_and_said(tmp_path: Path) -> None:
    design = tmp_path / "design.toml"
    design.write_text(builtin_text().replace("offset = 0.0", "offset = 20.0"))
    out = tmp_path / "out"
    only = [word for name in ("fig-01", "fig-09", "fig-11", "fig-13") for word in ("--only", name)]
    done = run("--design", str(design), "--out", str(out), "--size", "400x300", *only)
    assert done.returncode == 0, done.stderr
    assert "off_flank" in (out / "fig-09.csv").read_text()
    assert os.path.getsize(out / "fig-01.png") > 1000
