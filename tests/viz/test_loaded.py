"""Load sharing and transmission error under load: `render-figures --loaded`."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from beveloid_geom import builtin_design, first_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export import identifier
from beveloid_geom.export.fea.pair_deck import write_pair_deck
from beveloid_geom.export.fea.pair_mesh import PairMesh, force_lever, pair_mesh
from beveloid_geom.shapes.element_sizes import Cells
from beveloid_viz.cli import main
from beveloid_viz.figures.results import load_sharing
from beveloid_viz.figures.results.load_sharing import decks_of, loaded_pair
from beveloid_viz.rendering import theme
from tests.cli.running import refused as refused_by
from tests.symmetry import scaled

from .pages import page_of, table_in, words
from .test_print import faults, in_print

DESIGN = builtin_design()
PITCH = 2.0 * np.pi / 29.0
SHARES = (0.0, 0.7, 0.3), (0.0, 1.0, 0.0), (0.4, 0.6, 0.0)
TURN = 2e-4
refused = partial(refused_by, program=main)
FORCE = 1000.0


HEAD = "   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)"
TIME = "and time  0.2000000E+01"


def printed(pair: PairMesh, shares: tuple[float, ...], turn: float) -> str:
    """Return the output of CalculiX for given shares of a normal force and a rotation of the pinion."""
    pose = meshing_pair(DESIGN, pair.flank)
    (_, origin), point = pair.frames[0], pose.contact
    lines = []
    for both, share in zip(pair.contacts, shares, strict=True):
        force = -share * FORCE * pose.path.normal[1]
        slave, master = (identifier(name).upper() for name in both)
        centre = point if share else np.full(3, np.nan)
        lines += ["", f" statistics for slave set {slave}, master set {master} {TIME}", "", HEAD, ""]
        lines += [in_columns(np.append(force, np.cross(point, force))), ""]
        lines += ["   center of gravity and mean normal", "", in_columns(np.append(centre, force))]
    x, y, _ = pair.mesh.points[pair.mesh.node_sets["pinion gauge"][0]] - origin
    lines += ["", f" displacements (vx,vy,vz) for set PINION_GAUGE {TIME}", ""]
    lines += [f"        12 {in_columns(turn * np.array((-y, x, 0.0)))}", ""]
    return "\n".join(lines)


def in_columns(numbers: FloatArray) -> str:
    return "  ".join(f"{x:.8E}" for x in numbers)


@pytest.fixture(scope="module")
def decks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write decks at three rolls with results."""
    folder = tmp_path_factory.mktemp("decks")
    pose = meshing_pair(DESIGN)
    for k, shares in enumerate(SHARES):
        roll = float(pose.roll[0]) + PITCH * (k - 1) / 3.0
        pair = pair_mesh(
            DESIGN, pose, roll, force=FORCE, across=0.2, cells=Cells(1, 2, 2, 2, 1), bore_radii=(80.0, 80.0)
        )
        write_pair_deck(folder / f"p-{k + 1}.inp", DESIGN, pair, FORCE * force_lever(DESIGN), decks=3)
        (folder / f"p-{k + 1}.dat").write_text(printed(pair, shares, TURN * (1.0 + 0.1 * k)))
    return folder / "p.inp"


def test_what_is_read_is_what_was_printed(decks: Path) -> None:
    """Results are sorted by roll; the rigid pair is the first contact of the design."""
    found = loaded_pair(DESIGN, decks)
    np.testing.assert_allclose([one.share for one in found.results], SHARES, atol=1e-7)
    np.testing.assert_allclose(found.turns, TURN * np.array((1.0, 1.1, 1.2)), rtol=1e-6)
    for one in found.results:
        np.testing.assert_allclose(
            one.moment.sum(axis=0), one.torque * np.array((-1.0, 45.0 / 29.0)), rtol=1e-6
        )
        np.testing.assert_allclose(one.centre[np.array(one.share) == 0.0], np.nan)
    rolls = np.array([one.rolls[0] for one in found.results])
    rigid = first_contact(DESIGN, "right", rolls).transmission_error
    # The load turns the pinion further, so that the gear lags behind.
    np.testing.assert_allclose(found.loaded, rigid - 29.0 / 45.0 * found.turns, rtol=0.0, atol=1e-15)
    at, share = found.shares
    assert (np.diff(at) > 0.0).all()
    np.testing.assert_allclose(at[share == 1.0], 0.0, atol=1e-12)
    np.testing.assert_allclose(found.pitches(found.ends), np.array((-0.5, 0.5)) * 1.651001, atol=1e-5)


def test_the_page_shows_them(decks: Path) -> None:
    found = loaded_pair(DESIGN, decks)
    page = page_of(load_sharing.draw, found, (1600, 1200))
    shares, errors, _ = page.axes
    marks = next(line for line in shares.lines if line.get_marker() == "o")
    np.testing.assert_allclose(np.asarray(marks.get_ydata(), dtype=float), 100.0 * found.shares[1])
    loaded = next(line for line in errors.lines if line.get_marker() == "o")
    drawn = np.asarray(loaded.get_ydata(), dtype=float)
    np.testing.assert_allclose(drawn, np.degrees(found.loaded - found.loaded.mean()) * 3600.0, atol=1e-9)
    assert "N m on the pinion, right flanks; 3 rolls" in words(page)


@pytest.mark.parametrize("width", [90.0, 190.0])
def test_in_print_words_keep_clear(decks: Path, width: float) -> None:
    with theme.style():
        page = load_sharing.RECIPES["load-sharing"].drawn(loaded_pair(DESIGN, decks), in_print(width)).page
    assert not faults(page)


def test_the_command_draws_the_decks(decks: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = CliRunner().invoke(main, ["--loaded", str(decks), "--out", str(out), "--size", "600x450"])
    assert done.exit_code == 0, done.output
    table = table_in(out / "load-sharing.csv")
    loaded = [row for row in table if row["kind"] == "loaded"]
    np.testing.assert_allclose([float(row["share"]) for row in loaded], np.ravel(SHARES), atol=1e-7)
    assert [row["tooth_pair"] for row in loaded[:3]] == ["-1", "0", "1"]
    assert len(table) == 9 + 201 + 2
    found = loaded_pair(DESIGN, decks)
    shares = sorted((float(row["tooth_pair_pitches"]), float(row["share"])) for row in loaded)
    np.testing.assert_allclose(shares, np.transpose(found.shares), rtol=1e-12)
    at = [float(row["pitches"]) for row in loaded[::3]]
    np.testing.assert_allclose(at, found.pitches(found.loaded_rolls), rtol=1e-12)
    ends = [float(row["pitches"]) for row in table if row["kind"] == "end of path"]
    np.testing.assert_allclose(ends, found.pitches(found.ends), rtol=1e-12)
    assert (out / "load-sharing.png").stat().st_size > 10_000


def test_what_is_no_result_is_refused(decks: Path, tmp_path: Path) -> None:
    given = "--loaded", str(decks), "--out", str(tmp_path / "out")
    assert "leave out --only, --set" in refused(*given, "--only", "fig-09")
    assert "belong to another design: name it with --design" in refused(*given, "--design", "marine-gearbox")
    lost = refused("--loaded", str(tmp_path / "none.inp"), "--out", str(tmp_path / "out"))
    assert "none.inp (No such file or directory): write it with beveloid-geom mesh --part pair" in lost
    assert decks_of(decks) == [decks.with_stem(f"p-{k}") for k in (1, 2, 3)]
    unsolved = tmp_path / "q-1.inp"
    unsolved.write_text(decks.with_stem("p-1").read_text())
    given = "--loaded", str(tmp_path / "q.inp"), "--out", str(tmp_path / "o")
    assert "q-1.dat (No such file or directory): run ccx first" in refused(*given)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("size", [0.5, 1.001])
def test_decks_of_another_size_are_refused(decks: Path, size: float) -> None:
    """Teeth of the same shape touch at the same rolls for every size."""
    with pytest.raises(ValueError, match="the mid-faces differ by"):
        loaded_pair(scaled(DESIGN, size), decks)


def copied(decks: Path, folder: Path, *names: str) -> Path:
    """Copy decks and results under other names."""
    for k, name in enumerate(names):
        for suffix in (".inp", ".dat"):
            source = decks.with_name(f"p-{k + 1}{suffix}")
            (folder / f"{name}{suffix}").write_text(source.read_text())
    return folder / "p.inp"


def test_decks_of_other_rolls_are_not_mixed(decks: Path, tmp_path: Path) -> None:
    """Incomplete sets, old decks, and a single deck next to those of `--rolls` are refused."""
    path = copied(decks, tmp_path, "p-1", "p-2")
    given = "--loaded", str(path), "--out", str(tmp_path / "out")
    assert f"there are 2 decks of {path}, written by --rolls 3: remove them all and write" in refused(*given)
    new = copied(decks, tmp_path, "p-1", "p-2", "p-3").with_stem("p-3")
    new.write_text(new.read_text().replace('"decks": 3', '"decks": 2'))
    assert f"there are 3 decks of {path}, written by --rolls 2 and 3: remove them all" in refused(*given)
    copied(decks, tmp_path, "p")
    assert f"there are both {path} and {path.with_stem('p-1')}: remove the unwanted files" in refused(*given)


def test_a_single_deck(decks: Path, tmp_path: Path) -> None:
    path = copied(decks, tmp_path, "p")
    assert decks_of(path) == [path]
    found = loaded_pair(DESIGN, path)
    assert len(found.results) == 1
    page = page_of(load_sharing.draw, found, (1600, 1200))
    legend = page.axes[1].get_legend()
    assert legend is not None
    assert legend.get_texts()[1].get_text().startswith("loaded, one roll: ")
    page.axes[2].set_yticks([-0.015, 0.0, 0.015])  # 6 characters
    page.draw_without_rendering()
    assert page.axes[2].yaxis.label.get_window_extent().x1 < page.bbox.x1


def test_decks_name_their_design(decks: Path, tmp_path: Path) -> None:
    """A narrower face has the same rolls and mid-faces, so that the name in the header is compared."""
    path = copied(decks, tmp_path, "p")
    head, rest = path.read_text().split("\n** pair in contact", 1)
    path.write_text(f"{head}\n** pair of narrow.toml, 3 teeth of each\n** pair in contact{rest}")
    error = refused("--loaded", str(path), "--out", str(tmp_path / "out"))
    assert f"the decks of {path} belong to narrow.toml, not to ni-2017: name it with --design" in error
    path.write_text(path.read_text().replace("narrow.toml", "ni-2017.toml"))
    done = CliRunner().invoke(
        main, ["--loaded", str(path), "--out", str(tmp_path / "out"), "--size", "400x300"]
    )
    assert done.exit_code == 0, done.output
