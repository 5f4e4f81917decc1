"""Films of the pair in mesh: motion, frames, files, refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image as Pillow, ImageSequence

from beveloid_geom import builtin_design
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_viz.film import scene
from beveloid_viz.film.cli import main
from beveloid_viz.film.motion import Film, film_of
from beveloid_viz.rendering import theme
from tests.cli.running import refused, run
from tests.symmetry import mirrored
from tests.viz.test_snapshots import LIMIT, difference

SNAPSHOT = Path(__file__).parents[1] / "snapshots" / "film.png"
SIZE = (480, 360)
SMALL = ("--size", "320x240", "--seconds", "0.3", "--fps", "10")
Image = NDArray[np.uint8]


@pytest.fixture(scope="module")
def plain() -> Film:
    return film_of(builtin_design(), "right", 5)


@pytest.fixture(scope="module")
def modified() -> Film:
    return film_of(builtin_design().with_parabola(0.001, -0.001), "right", 5, "pair")


def frames_of(path: Path) -> list[Image]:
    with Pillow.open(path) as film:
        assert film.info["loop"] == 0
        return [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(film)]


def test_contacts_of_unmodified_flanks_are_on_the_path(plain: Film) -> None:
    """Tooth pairs touch at the rolls of the path of contact, at its z on both members."""
    path, cycle = plain.path.path, plain.report.cycle
    roll = float(cycle.start) + cycle.pitch * (np.arange(5) / 5 + plain.pairs[:, None])
    inside = (roll > path.pinion_roll.min()) & (roll < path.pinion_roll.max())
    assert inside.sum() >= 8
    assert (plain.touching == inside).all()
    order = np.argsort(path.pinion_roll)
    for number, z in enumerate((path.pinion_z, path.gear_z)):
        expected = np.interp(roll, path.pinion_roll[order], z[order])
        np.testing.assert_allclose(plain.on_tooth_0(number)[..., 2][inside], expected[inside], atol=2e-3)


def test_line_contact_is_drawn_along_its_lines(tmp_path: Path) -> None:
    """Each contact lies on the line of its tooth pair, which is drawn over the path."""
    film = film_of(builtin_design("anti-backlash"), "right", 3, "pair")
    touching = film.touching
    assert np.isfinite(film.lines[0][touching]).all()
    for number in (0, 1):
        (start, end), point = (
            np.moveaxis(film.lines[number][touching], 1, 0),
            film.on_tooth_0(number)[touching],
        )
        off = np.linalg.norm(np.cross(point - start, end - start), axis=1) / np.linalg.norm(
            end - start, axis=1
        )
        assert off.max() < 1e-3
    step = int(np.argmax(touching.any(axis=0)))
    in_mesh = film.line_in_mesh(step)[touching[:, step]]
    mesh_points = film.point[touching[:, step], step]
    way = in_mesh[:, 1] - in_mesh[:, 0]
    assert np.linalg.norm(np.cross(mesh_points - in_mesh[:, 0], way), axis=1).max() < 1e-3 * np.linalg.norm(
        way
    )
    assert "orange: path of contact" in scene.film_title(film)
    pages = []
    for shown in (film, replace(film, lines=(np.full_like(film.lines[0], np.nan),) * 2)):
        scene.write_film(shown, tmp_path / "film.gif", SIZE, 10.0, [step, step])
        pages.append(frames_of(tmp_path / "film.gif")[0])
    assert difference(*pages) > 50.0 * LIMIT


def test_point_contact_has_no_lines(modified: Film) -> None:
    assert np.isnan(modified.lines[0]).all()


def test_the_transmission_error_is_that_of_the_mesh_cycle(modified: Film) -> None:
    """It is measured from the unmodified pair, as in `operation`, not from the mean."""
    error = np.degrees(modified.report.first.transmission_error[1]) * 3600.0
    assert abs(float(modified.report.cycle.mean)) > 1e-6
    assert f"transmission error {theme.signed(error, 2)} arcsec" in scene.readings(modified, 1)


def test_teeth_do_not_overlap(modified: Film) -> None:
    gap = modified.gap
    assert np.nanmin(gap) > -1e-9
    assert (modified.touching.sum(axis=0) == 1).all()
    assert MARKING_SEPARATION_MM > np.nanmin(gap[~modified.touching]) > 0.0


@pytest.mark.slow
def test_a_mirrored_pair_moves_as_the_mirror_image(modified: Film) -> None:
    """Left flanks of the mirrored pair drive in the opposite sense, and tooth pair k moves like -k."""
    one, other = modified, film_of(mirrored(modified.path.design), "left", 5)
    rows, compared = one.pairs.tolist(), 0
    for i, j in ((0, 0), (1, 4), (2, 3), (3, 2), (4, 1)):
        for k, pair in enumerate((-other.pairs - (i > 0)).tolist()):  # steps 1 to 4 are a pitch later
            if pair in rows and one.near[rows.index(pair), j]:
                row, compared = rows.index(pair), compared + 1
                assert other.gap[k, i] == pytest.approx(one.gap[row, j], abs=1e-9)
                np.testing.assert_allclose(other.point[k, i], one.point[row, j] * (1, -1, 1), atol=1e-4)
    assert compared == other.near.sum() == one.near.sum()


def test_frames(modified: Film, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    """The teeth move from frame to frame, and the first frame is the reference picture."""
    scene.write_film(modified, tmp_path / "film.gif", SIZE, 10.0, [0, 2, 0])
    first, middle, again = frames_of(tmp_path / "film.gif")
    mesh = slice(60, None), slice(0, 290)  # the teeth in mesh, without text
    assert difference(first[mesh], middle[mesh]) > 100.0 * LIMIT
    assert difference(first, again) <= LIMIT
    if request.config.getoption("--reset-snapshots"):
        Pillow.fromarray(first).save(SNAPSHOT)
    assert difference(first[mesh], np.asarray(Pillow.open(SNAPSHOT).convert("RGB"))[mesh]) <= LIMIT


@pytest.mark.parametrize("name", ["$a$-" * 30, "\u6b6f\u8eca \u0416\u00e4.toml"])
def test_titles_have_no_missing_letters(modified: Film, name: str) -> None:
    object.__setattr__(modified.report, "name", name)
    first = scene.film_title(modified).split(",")[0]
    assert first == "?? \u0416\u00e4.toml" if "toml" in name else len(first) == 40


def test_gif(tmp_path: Path) -> None:
    out = tmp_path / "mesh.GIF"
    done = run("--out", out, *SMALL, "--pitches", "2", program=main)
    assert done.exit_code == 0, done.stderr
    assert "mesh.GIF: 6 frames, 0.6 s" in done.stdout
    assert [path.name for path in out.parent.iterdir()] == ["mesh.GIF"]
    frames = frames_of(out)
    assert [frame.shape for frame in frames] == [(240, 320, 3)] * 6
    assert difference(frames[1], frames[4]) <= LIMIT  # the second pitch repeats the first


def test_mp4(tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="the encoder of films, extra `film`")
    out = tmp_path / "mesh.mp4"
    done = run("--out", out, *SMALL, program=main)
    assert done.exit_code == 0, done.stderr
    content = out.read_bytes()
    assert 0 < content.find(b"moov") < content.find(b"mdat")  # browsers play it while it is loaded
    film = ffmpeg.read_frames(str(out))
    details = next(film)
    film.close()
    assert (details["size"], details["codec"], details["fps"]) == ((320, 240), "h264", 10.0)


@pytest.mark.parametrize(
    ("arguments", "reason", "status"),
    [
        (("--offset-error", "20"), "the path of contact does not meet the right flanks", 1),
        (("--parabola-pinion", "0.01"), "could not be computed: pinion: tip_radius 0.38 is too large", 4),
    ],
)
def test_a_pair_without_motion(arguments: tuple[str, ...], reason: str, status: int, tmp_path: Path) -> None:
    done = run("--out", tmp_path / "mesh.gif", *arguments, program=main)
    assert done.exit_code == status
    assert reason in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_missing_encoder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("beveloid_viz.film.cli.find_spec", lambda _: None)
    assert "pip install 'beveloid-geom[film]'" in refused("--out", tmp_path / "mesh.mp4", program=main)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(scene, "write_film", full)
    done = run("--out", tmp_path / "mesh.gif", *SMALL, program=main)
    assert done.exit_code == 2
    assert "No space left on device" in done.stderr
    assert list(tmp_path.iterdir()) == []
