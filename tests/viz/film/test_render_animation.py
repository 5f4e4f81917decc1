"""The command `render-animation`: what moves is right, the loop has no seam, the files play."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from matplotlib.axis import Axis
from matplotlib.colors import to_rgb
from matplotlib.image import imread, imsave
from matplotlib.text import Text
from PIL import Image as Pillow, ImageSequence

from beveloid_geom import builtin_design
from beveloid_geom.arrays import FloatArray
from beveloid_geom.pair.frames import to_fixed
from beveloid_viz.film import page, writer, zone
from beveloid_viz.film.cli import main
from beveloid_viz.film.motion import CURVE, FILM, Film, Motion, film_of, motion_at
from beveloid_viz.film.page import Image, Sheet
from beveloid_viz.parts import posed
from beveloid_viz.stage import theme
from beveloid_viz.stage.opengl import require_opengl
from beveloid_viz.stage.scene import Picture
from tests.symmetry import mirrored
from tests.viz.test_snapshots import LIMIT, difference

COMMAND = Path(sys.executable).with_name("render-animation")
SNAPSHOT = Path(__file__).parents[1] / "snapshots" / "film.png"
SIZE = (400, 300)
LONGEST = (
    "148.97\u00b0  (11.999 pitches)",
    "\u22121234.56 arcsec",
    "2  (4 within 6.35 \u00b5m)",
    "gear tip and pinion heel",
)
"""Numbers of a film, as long as they get."""
SMALL = ("--size", "320x240", "--seconds", "0.4", "--fps", "10")


@pytest.fixture(scope="module", autouse=True)
def _opengl() -> None:
    require_opengl()


@pytest.fixture(scope="module")
def plain() -> Film:
    return film_of(builtin_design(), "right", 5)


@pytest.fixture(scope="module")
def modified() -> Film:
    return film_of(builtin_design().with_parabola(0.001, -0.001), "right", 5)


@pytest.fixture(scope="module")
def frames(modified: Film) -> list[Image]:
    return list(page.frames(modified, SIZE))


@pytest.fixture(scope="module")
def sheet(modified: Film) -> Sheet:
    return page.sheet_of(modified, SIZE, 1)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments)


def teeth_of(sheet: Sheet, image: Image) -> Image:
    """The picture of the teeth out of a frame."""
    box = sheet.box
    top = SIZE[1] - box.bottom - box.height
    return image[top : top + box.height, box.left : box.left + box.width]


def test_contacts_are_those_of_the_path(plain: Film) -> None:
    """Without modification the rigid pair touches on its path: both z and roll agree."""
    motion, path = plain.motion, plain.path.path
    pitch = plain.cycle.cycle.pitch
    roll = float(plain.cycle.cycle.start) + pitch * (motion.share + motion.pairs[:, None])
    inside = (roll > path.pinion_roll.min()) & (roll < path.pinion_roll.max())
    assert inside.sum() >= 8
    assert (motion.touching == inside).all()
    order = np.argsort(path.pinion_roll)
    for row, z in enumerate((path.pinion_z, path.gear_z)):
        expected = np.interp(roll, path.pinion_roll[order], z[order])
        np.testing.assert_allclose(motion.own[row, ..., 2][inside], expected[inside], atol=2e-3)


def test_contacts_stand_on_both_teeth(modified: Film) -> None:
    """Points in the members' own frames, carried to S_f, are where the pair touches."""
    motion = modified.motion
    for number, (frame, member) in enumerate(zip(motion.frames, motion.design.members, strict=True)):
        for k, pair in enumerate(motion.pairs.tolist()):
            tooth = -pair if number else pair
            placed = to_fixed(frame, posed.on_tooth(motion.own[number, k], member, tooth))
            off = np.linalg.norm(placed - motion.point[k], axis=-1)
            near = motion.near[k]
            room = motion.gap[k] * number  # what is between the gear's tooth and the pinion's
            assert (off[near] <= 2.0 * room[near] + 1e-9).all()


def test_no_teeth_overlap(modified: Film) -> None:
    gap = modified.motion.gap
    assert np.nanmin(gap) > -1e-9
    assert (modified.motion.touching.sum(axis=0) == 1).all()
    assert FILM > np.nanmin(gap[~modified.motion.touching]) > 0.0


@pytest.mark.slow
def test_a_mirrored_pair_moves_as_its_mirror_image(modified: Film) -> None:
    """Its left flanks drive as the right ones did, the other way round: tooth pair k as -k did."""
    one, other = modified.motion, film_of(mirrored(modified.motion.design), "left", 5).motion
    rows, seen = one.pairs.tolist(), 0
    for i, j in ((0, 0), (1, 4), (2, 3), (3, 2), (4, 1)):
        assert other.error[i] == pytest.approx(-one.error[j], abs=1e-13)
        for k, pair in enumerate((-other.pairs - (i > 0)).tolist()):  # a pitch lies between all but the first
            if pair in rows and one.near[rows.index(pair), j]:
                row, seen = rows.index(pair), seen + 1
                assert other.gap[k, i] == pytest.approx(one.gap[row, j], abs=1e-9)
                np.testing.assert_allclose(other.point[k, i], one.point[row, j] * (1, -1, 1), atol=1e-4)
    assert seen == other.near.sum() == one.near.sum()


def test_the_error_is_that_of_the_cycle_less_its_mean(modified: Film) -> None:
    error = modified.cycle.first.transmission_error
    at_start = error[0] - error[:-1].mean()
    assert modified.motion.error[0] == pytest.approx(at_start, abs=0.01 * np.ptp(error))
    assert len(error) == CURVE + 1
    assert modified.motion.carriers == modified.cycle.carriers[: -1 : CURVE // 5]


def test_balls_are_where_the_teeth_touch(modified: Film, sheet: Sheet, frames: list[Image]) -> None:
    motion = modified.motion
    camera = zone.camera_of(modified, sheet.box.size)
    corner = np.array([sheet.box.left, SIZE[1] - sheet.box.bottom - sheet.box.height])
    teeth = Picture(np.zeros((sheet.box.height, sheet.box.width, 3), np.uint8), camera, 0)
    for step, image in enumerate(frames):
        seen = teeth.project(motion.point[motion.touching[:, step], step])
        assert_ball(image, seen + corner)
        for row, flank in enumerate(sheet.flanks):
            assert flank is not None
            own = motion.own[row, motion.touching[:, step], step]
            axes = sheet.moving.balls[1 + row][0].axes
            assert axes is not None
            pixels = axes.transData.transform(flank.place(own))
            assert_ball(image, pixels * (1.0, -1.0) + (0.0, SIZE[1]))


def assert_ball(image: Image, pixels: FloatArray) -> None:
    colour = 255.0 * np.array(to_rgb(page.BALL))
    for x, y in pixels:
        found = image[int(y), int(x)]
        assert np.abs(found - colour).max() < 30.0, (x, y, found)


def test_the_loop_has_no_seam(modified: Film, sheet: Sheet) -> None:
    """After one pitch the teeth, and the balls on the flanks, are where they were."""
    both = replace(modified, motion=motion_at(modified.cycle, np.array([0.0, 1.0])))
    first, last = page.frames(both, SIZE)
    assert difference(teeth_of(sheet, first), teeth_of(sheet, last)) <= LIMIT
    flanks = slice(0, int((1.0 - page.FLANKS) * SIZE[1]))
    assert difference(first[flanks], last[flanks]) <= LIMIT


@pytest.mark.parametrize("name", ["pair.toml", "$a$-" * 30])
def test_words_are_legible_and_stand_clear_at_960_pixels(modified: Film, name: str) -> None:
    """No letter under 14 pixels, none within 10 pixels of the edge, no word over another, however long."""
    film = replace(modified, cycle=replace(modified.cycle, name=name))
    with theme.style():
        sheet = page.sheet_of(film, (960, 720), 12)
        for text, words in zip(sheet.moving.numbers, LONGEST, strict=True):
            text.set_text(words)
        canvas: Any = sheet.page.canvas
        canvas.draw()
        outside = [label for axes in sheet.page.axes for label in (*unseen(axes.xaxis), *unseen(axes.yaxis))]
        found = [each for each in sheet.page.findobj(Text) if isinstance(each, Text) and each not in outside]
        texts = [text for text in found if text.get_text().strip() and text.get_visible()]
        boxes = [
            (text.get_text(), text.get_window_extent(canvas.get_renderer()).get_points()) for text in texts
        ]
    assert len(boxes) > 25
    assert min(float(text.get_fontsize()) * sheet.page.dpi / 72.0 for text in texts) >= 14.0
    for words, ((left, bottom), (right, top)) in boxes:
        assert 10.0 <= left < right <= 950.0, words
        assert 10.0 <= bottom < top <= 710.0, words
    for i, (one, first) in enumerate(boxes):
        for other, second in boxes[:i]:
            apart = np.maximum(first[0] - second[1], second[0] - first[1]).max()
            assert apart > -1.0, (one, other)
    title = boxes[[words.endswith("right flanks in mesh") for words, _ in boxes].index(True)][0]
    assert title.startswith(name if len(name) < 40 else r"\$a\$-")
    assert any("0.001 and \u22120.001" in words for words, _ in boxes)


def unseen(axis: Axis) -> list[Text]:
    """Labels of ticks beyond the ends of an axis, which are not drawn."""
    low, high = axis.get_view_interval()
    return [tick.label1 for tick in axis.get_major_ticks() if not low <= tick.get_loc() <= high]


def test_nothing_touches_the_edge(frames: list[Image]) -> None:
    for image in frames:
        rim = np.ones(image.shape[:2], bool)
        rim[4:-4, 4:-4] = False  # of 400 pixels: 10 of 960
        assert (image[rim] == 255).all()


def test_frames_differ(sheet: Sheet, frames: list[Image]) -> None:
    assert all(image.shape == (SIZE[1], SIZE[0], 3) for image in frames)
    for one, other in zip(frames, [*frames[1:], frames[0]], strict=True):
        assert difference(teeth_of(sheet, one), teeth_of(sheet, other)) > 100.0 * LIMIT


def test_snapshot(modified: Film, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    picture = next(zone.pictures(modified, (240, 240))).image
    if request.config.getoption("--reset-snapshots"):
        imsave(SNAPSHOT, picture)
    error = difference(picture, (imread(SNAPSHOT)[..., :3] * 255.0 + 0.5).astype(np.uint8))
    imsave(tmp_path / "film.png", picture)
    assert error <= LIMIT, f"differs by {error:.1f} pixels: see {tmp_path}"


def solved(patch: pytest.MonkeyPatch, film: Film) -> None:
    """Let the command take this film instead of its own."""
    patch.setattr("beveloid_viz.film.motion.film_of", lambda *_: film)


def test_gif(modified: Film, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solved(monkeypatch, modified)
    out = tmp_path / "new" / "mesh.gif"
    done = run("--out", str(out), *SMALL, "--pitches", "2")
    assert done.exit_code == 0, done.stderr
    assert "mesh.gif: 10 frames, 1 s" in done.stdout
    assert "10/10" in done.stderr
    assert [path.name for path in out.parent.iterdir()] == ["mesh.gif"]
    with Pillow.open(out) as film:
        assert (film.size, film.info["loop"]) == ((320, 240), 0)
        colours = []
        for frame in ImageSequence.Iterator(film):
            assert frame.info["duration"] == 100
            colours.append(np.asarray(frame.convert("RGB")))
    assert len(colours) == 10
    assert (colours[0][0, 0] == 255).all()
    zone_only = (slice(40, 200), slice(20, 180))
    assert difference(colours[0][zone_only], colours[5][zone_only]) <= 2.0 * LIMIT


def test_mp4(plain: Film, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if writer.encoder() is None:
        pytest.skip("no encoder: neither imageio-ffmpeg nor ffmpeg is installed")
    out = tmp_path / "mesh.MP4"
    solved(monkeypatch, plain)
    done = run("--out", str(out), *SMALL)
    assert done.exit_code == 0, done.stderr
    content = out.read_bytes()
    assert 0 < content.find(b"moov") < content.find(b"mdat")  # it plays while it is loaded
    reader = pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg reads the film back")
    assert reader.count_frames_and_secs(str(out)) == (5, pytest.approx(0.5, abs=0.01))
    film = reader.read_frames(str(out))
    details = next(film)
    film.close()
    assert (details["size"], details["codec"], details["fps"]) == ((320, 240), "h264", 10.0)
    assert details["pix_fmt"].startswith("yuv420p")


def test_an_encoder_that_fails_is_quoted(tmp_path: Path) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\necho no libx264 >&2\nexit 1\n")
    program.chmod(0o755)
    blank = [np.zeros((40, 40, 3), np.uint8)] * 100
    with pytest.raises(OSError, match="ffmpeg: no libx264"):
        writer.write_mp4(blank, tmp_path / "x.mp4", 10.0, str(program))


def test_a_missing_encoder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "encoder", lambda: None)
    done = run("--out", str(tmp_path / "mesh.mp4"), *SMALL)
    assert done.exit_code == 2
    assert "pip install 'beveloid-geom[film]'" in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_no_contact_says_why(tmp_path: Path) -> None:
    for words, reason in (
        (("--offset-error", "20"), "the path of contact does not meet the right flanks"),
        (("--parabola-pinion", "-0.01"), "a member is undercut"),
        (("--parabola-pinion", "0.01"), "tip_radius 0.38 is too large"),
    ):
        done = run("--out", str(tmp_path / "new" / "mesh.gif"), *words)
        assert done.exit_code == 1
        assert reason in done.stderr
        assert done.stderr.count("\n") == 1
        assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written(plain: Film, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solved(monkeypatch, plain)
    blocked = tmp_path / "file"
    blocked.write_text("")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(writer, "write_gif", full)
    done = run("--out", str(tmp_path / "mesh.gif"), *SMALL)
    assert done.exit_code == 2
    assert "No space left on device" in done.stderr
    assert list(tmp_path.iterdir()) == [blocked]


def test_an_interrupt_ends_the_encoder(tmp_path: Path) -> None:
    """It waits for frames: a film that breaks off must not leave it behind."""
    waiting, number = tmp_path / "ffmpeg", tmp_path / "number"
    waiting.write_text(f"#!/bin/sh\necho $$ > {number}\nexec sleep 60\n")
    waiting.chmod(0o755)

    def broken() -> Iterator[Image]:
        yield np.zeros((40, 40, 3), np.uint8)
        while not (number.exists() and number.read_text().endswith("\n")):
            time.sleep(0.01)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        writer.write_mp4(broken(), tmp_path / "mesh.mp4", 10.0, str(waiting))
    with pytest.raises(ProcessLookupError):
        os.kill(int(number.read_text()), 0)


def test_motion_is_a_row_of_positions(plain: Film) -> None:
    motion: Motion = plain.motion
    np.testing.assert_allclose(motion.share, np.arange(5) / 5)
    assert motion.gap.shape == (motion.pairs.size, 5) == (8, 5)  # the nearest, three beside, one to come
    assert np.abs(motion.error).max() < 1e-13  # without modification there is none
    assert set(motion.carriers) == {"flanks"}
