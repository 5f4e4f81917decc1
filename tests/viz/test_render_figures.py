"""The command `render-figures`: output, errors, and machines without OpenGL."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from matplotlib.image import imread

from beveloid_geom import Modification, builtin_design
from beveloid_geom.design.file import builtin_text
from beveloid_viz.cli import chosen_figures, main
from beveloid_viz.figures import FIGURES
from beveloid_viz.figures.paper import fig_11_contact_ratio as fig_ratio
from beveloid_viz.figures.results import ease_off
from beveloid_viz.rendering import opengl

from ..symmetry import scaled
from .pages import recipe_of, table_in

COMMAND = Path(sys.executable).with_name("render-figures")


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([COMMAND, *arguments], capture_output=True, text=True, check=False)


def test_figures_are_written_with_their_numbers(tmp_path: Path) -> None:
    out = tmp_path / "new" / "figures"
    done = run("--only", "fig-07", "--only", "fig-02", "--out", str(out), "--size", "640x480")
    assert done.returncode == 0, done.stderr
    assert str(out) in done.stdout
    assert "triangles" in done.stdout
    assert sorted(p.name for p in out.iterdir()) == ["fig-02.csv", "fig-02.png", "fig-07.csv", "fig-07.png"]
    assert imread(out / "fig-07.png").shape[:2] == (480, 640)
    rows = table_in(out / "fig-07.csv")
    assert {row["member"] for row in rows} == {"pinion", "gear"}
    path = [row for row in rows if row["index"]]
    assert {row["status"] for row in path} == {"solved"}
    assert len(path) == 5 * 2 * 101
    # Rolls on both sides of each change of the contact; the rest of a pitch where Eq. 16 is below 1.
    rest = [row for row in rows if not row["index"]]
    assert {row["status"] for row in rest} == {"", "off_flank"}
    assert all(row["edge_that_touches"] and math.isfinite(float(row["edge_z_mm"])) for row in rest)
    assert all(float(row["contact_ratio"]) < 1.0 for row in rest if row["status"])
    straight = next(row for row in rows if float(row["a1_per_mm"]) == 0.0)
    assert float(straight["contact_ratio"]) == pytest.approx(1.651001, abs=1e-6)


def test_a_notebook_and_a_read_only_home_do_not_matter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Figures are drawn although a notebook exports its backend and the folders of Matplotlib are not
    writable."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    monkeypatch.setenv("HOME", "/proc/none")
    monkeypatch.setenv("TMPDIR", str(temporary))
    for name in ("MPLCONFIGDIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.delenv(name, raising=False)
    done = run("--only", "sliding", "--size", "320x240", "--jobs", "1", "--out", str(tmp_path / "out"))
    assert done.returncode == 0, done.stderr
    assert "atplotlib" not in done.stderr
    assert (tmp_path / "out" / "sliding.png").exists()
    assert not list(temporary.iterdir())


def test_processes_write_what_one_writes(tmp_path: Path) -> None:
    arguments = ["--only", "fig-02", "--only", "sliding", "--size", "320x240", "--out"]
    for jobs in ("1", "2"):
        done = CliRunner().invoke(main, [*arguments, str(tmp_path / jobs), "--jobs", jobs])
        assert done.exit_code == 0, done.output
        names = [line.split()[0] for line in done.stdout.splitlines()]
        assert names[:2] == ["fig-02", "sliding"]
    for name in ("fig-02.csv", "fig-02.png", "sliding.csv", "sliding.png"):
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
    """Simulate a process that the system kills."""
    os.abort()


def in_set(*sets: str) -> list[str]:
    return [figure.name for figure in FIGURES if figure.set in sets]


def test_list_names_the_figures_and_their_sets() -> None:
    """The only figure with measured times is the last one, because it is drawn alone."""
    done = CliRunner().invoke(main, ["--list"])
    assert done.exit_code == 0
    named = [(figure.name, figure.set) for figure in FIGURES]
    assert [tuple(line.split()[:2]) for line in done.stdout.splitlines()] == named
    assert in_set("paper") == [f"fig-{number:02d}" for number in range(1, 16)]
    assert [len(in_set(name)) for name in ("results", "methods")] == [13, 3]
    assert [figure.timed for figure in FIGURES] == [False] * (len(FIGURES) - 1) + [True]


@pytest.mark.parametrize(
    ("names", "sets", "chosen"),
    [
        ((), (), in_set("paper", "results")),
        ((), ("methods",), in_set("methods")),
        (("speed-accuracy", "fig-02"), (), ["fig-02", "speed-accuracy"]),
        (("fig-02",), ("methods",), ["fig-02", *in_set("methods")]),
    ],
)
def test_figures_are_chosen_by_name_and_set(
    names: tuple[str, ...], sets: tuple[str, ...], chosen: list[str]
) -> None:
    assert [figure.name for figure in chosen_figures(names, sets)] == chosen


def test_both_flanks_are_drawn(tmp_path: Path) -> None:
    """Figures of both flanks are drawn once, others for each flank. Left flanks of a pair have the numbers of
    the right flanks of its mirror image."""
    mirror = tmp_path / "mirror.toml"
    text = builtin_text().replace("helix_angle_deg = 25.0", "helix_angle_deg = -25.0")
    mirror.write_text(text.replace("helix_angle_deg = -10.57", "helix_angle_deg = 10.57"))
    for design, flank in (("ni-2017", "both"), (str(mirror), "right")):
        only = ["--only", "fig-09", "--only", "sliding", "--size", "320x240", "--jobs", "1"]
        only = only if flank == "both" else [*only[:2], *only[4:]]
        arguments = [*only, "--design", design, "--flank", flank, "--out", str(tmp_path / flank)]
        done = CliRunner().invoke(main, arguments)
        assert done.exit_code == 0, done.output
    names = sorted(path.stem for path in (tmp_path / "both").glob("*.png"))
    assert names == ["fig-09", "fig-09-left", "sliding"]
    left, right = (table_in(tmp_path / name) for name in ("both/fig-09-left.csv", "right/fig-09.csv"))
    assert len(left) == len(right) > 1000
    for one, other in zip(left, right, strict=True):
        if not one["index"]:  # between the positions of the path
            assert not other["index"]
            continue
        for name in ("contact_ratio", "z_mm", "r_mm", "length_mm", "operating_contact_ratio"):
            assert float(one[name]) == pytest.approx(float(other[name]), abs=1e-9)


def test_coefficients_and_errors_scale_with_the_module() -> None:
    """A pair of a third of the size has three times the coefficients and a third of the errors."""
    small = scaled(builtin_design(), 1.0 / 3.0)
    for name, times in (("fig-09", 3.0), ("fig-12", 1.0 / 3.0)):
        recipe = recipe_of(name)
        (header, own), (_, usual) = (
            recipe.rows(recipe.compute(design)) for design in (small, builtin_design())
        )
        column = list(header).index("a1_per_mm" if name == "fig-09" else "offset_error_mm")
        greatest, expected = (max(float(str(row[column])) for row in rows) for rows in (own, usual))
        assert greatest == pytest.approx(times * expected, rel=0.03)  # to two digits


def test_ease_off_of_modified_flanks_is_compared_with_unmodified_flanks() -> None:
    """A design with modifications only has the cases "unmodified" and "as designed". Crowning moves the flank
    at both ends of the face away from the mate."""
    design = builtin_design()
    crowned = replace(design, pinion=design.pinion.modified(Modification(helix_crowning_um=10.0)))
    plain, after = ease_off.compute(crowned)[:2]
    assert (plain.case, after.case) == ("unmodified", "as designed")
    assert plain.result is not None
    assert after.result is not None
    change = after.result.second_order.face_crowning - plain.result.second_order.face_crowning
    assert change == pytest.approx(0.010, rel=0.1)


def test_a_failed_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    done = CliRunner().invoke(main, ["--only", "fig-02", "--out", str(tmp_path), "--size", "400x300"])
    assert done.exit_code == 2
    assert "No space left on device" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_window_class_that_crashes_is_not_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    """A window class whose probe crashes is not chosen, and the program continues."""
    monkeypatch.setattr(opengl, "PROBE", "import os; os.abort()")
    assert not opengl.draws.__wrapped__("")  # not the cached answer


def test_window_classes() -> None:
    assert list(opengl.window_classes({opengl.VARIABLE: "mine", "DISPLAY": ":0"})) == ["mine"]
    assert list(opengl.window_classes({}, "darwin")) == [""]
    assert "" not in list(opengl.window_classes({}, "linux"))
    assert next(opengl.window_classes({"DISPLAY": ":0"}, "linux")) == ""


def test_flat_figures_need_no_opengl(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: object, **__: object) -> None:
        raise AssertionError("there is no OpenGL")

    monkeypatch.setattr(opengl, "draws", lambda _: False)
    monkeypatch.setattr("pyvista.Plotter", missing)
    names = ["fig-02", "sliding", "ease-off"]
    asked = [word for name in names for word in ("--only", name)]
    rest = ["--size", "400x300", "--jobs", "1", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(main, [*asked, *rest])
    assert done.exit_code == 0, done.output
    assert {file.stem for file in (tmp_path / "out").iterdir()} == set(names)
    assert CliRunner().invoke(main, [*asked, "--only", "fig-09", *rest]).exit_code == 3


@pytest.mark.slow
def test_a_design_without_contact_is_drawn_and_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    design = tmp_path / "design.toml"
    design.write_text(builtin_text().replace("offset = 0.0", "offset = 20.0"))
    out = tmp_path / "out"
    only = [word for name in ("fig-01", "fig-09", "fig-11", "fig-13") for word in ("--only", name)]
    monkeypatch.setattr(fig_ratio, "CYCLE_POINTS", slice(None, None, 80))
    asked = ["--design", str(design), "--out", str(out), "--size", "400x300", "--jobs", "1", *only]
    done = CliRunner().invoke(main, asked)
    assert done.exit_code == 0, done.output
    assert "off_flank" in (out / "fig-09.csv").read_text()
    assert os.path.getsize(out / "fig-01.png") > 1000
