"""`render-animation`: an animation of the pair in mesh as GIF or MP4."""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

from beveloid_geom.cli.options import (
    BUILTIN_DESIGN,
    NumberRange,
    Refusal,
    changed_design,
    flank_option,
    load_design,
    no_result,
    note_equal_teeth,
    override_options,
    write_out,
)
from beveloid_geom.cli.results import require_folder

from ..options import command, option, prepare_folder, require_drawing, size_option, writing

DEFAULT_OUT = Path("outputs/mesh.gif")


def check_format(out: Path, size: tuple[int, int], fps: float, frames: int) -> None:
    """Raise Refusal for a film that cannot be written in the format of the file name."""
    suffix, name = out.suffix.lower(), click.format_filename(out, shorten=True)
    fault = ""
    if out != DEFAULT_OUT:  # only the folder of the default is created
        require_folder(out)
    if suffix not in (".gif", ".mp4"):
        fault = f"--out: {name} ends in neither .gif nor .mp4"
    elif out.is_dir():
        fault = f"--out: {click.format_filename(out)} is a folder: name a file in it"
    elif frames < 2:
        fault = f"--seconds at --fps {fps:g} makes fewer than 2 frames: increase --seconds or --fps"
    elif suffix == ".gif" and abs(100.0 / fps - max(2, round(100.0 / fps))) > 1e-6:
        delays = sorted({max(2.0, 100.0 // fps + more) for more in (0, 1)}, reverse=True)
        rates = " or ".join(f"{100.0 / delay:.4g}" for delay in delays)
        delay_limits = "the delays of a GIF are whole hundredths of a second, at least 2"
        fault = f"--fps {fps:g}: {delay_limits}: choose {rates}, or write .mp4"
    elif suffix == ".mp4" and any(side % 2 for side in size):
        fault = f"--size {size[0]}x{size[1]}: both sides of an MP4 must be even"
    elif suffix == ".mp4" and find_spec("imageio_ffmpeg") is None:
        fault = "MP4 files need an encoder: pip install 'beveloid-geom[film]', or write .gif"
    if fault:
        raise Refusal([fault])


def _removed(folder: str) -> str:
    """Remove a temporary folder; return no message for the user."""
    shutil.rmtree(folder, ignore_errors=True)
    return ""


@command("render-animation")
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@option("--out", click.Path(path_type=Path), DEFAULT_OUT, "File to write, .gif or .mp4.", metavar="FILE")
@option("--pitches", click.IntRange(1, 100), 1, "Number of pitches of the pinion.")
@option("--seconds", NumberRange(0.1, 60.0), 3.0, "Duration of a pitch.", metavar="S")
@option(
    "--fps",
    NumberRange(1.0, 60.0),
    20.0,
    "Frames per second; for a GIF 100/n with a whole number n of at least 2.",
    metavar="N",
)
@size_option("960x720")
@override_options
def main(
    design: str,
    flank: str,
    out: Path,
    pitches: int,
    seconds: float,
    fps: float,
    size: tuple[int, int],
    **changes: Any,
) -> None:
    """Write an animation of the pair in mesh, with the contacts moving over the flanks.

    The position of the gear follows from the first contact of all teeth, edges included. Teeth are rigid and
    without load. The animation repeats without a jump. MP4 needs pip install 'beveloid-geom[film]'. The exit
    status is 1 without contact on the flanks, 4 if the motion could not be computed."""
    from tqdm import tqdm

    from beveloid_geom.support.atomic_file import atomic_file
    from beveloid_geom.support.process import undoing

    steps = round(seconds * fps)
    check_format(out, size, fps, steps)
    changed = changed_design(load_design(design), changes)
    note_equal_teeth(changed)
    begin, name = time.perf_counter(), click.format_filename(out)
    require_drawing()

    from .motion import NoFilmError, film_of
    from .scene import write_film

    try:
        film = film_of(changed, flank, steps, click.format_filename(design, shorten=True))
        prepare_folder(out.parent)
        with (
            writing(name, ": choose another with --out"),
            atomic_file(out) as part,
            tempfile.TemporaryDirectory() as folder,
            undoing(partial(_removed, folder)),  # a signal ends the process at once
            tqdm([*range(steps)] * pitches, desc="frames", unit="frame", file=sys.stderr) as order,
        ):
            made = Path(folder) / f"film{out.suffix.lower()}"  # the encoders choose the format by the suffix
            write_film(film, made, size, fps, order)
            part.write_bytes(made.read_bytes())
    except NoFilmError as error:
        raise no_result(error.args[0], "no animation") from None
    count, megabytes = steps * pitches, 1e-6 * out.stat().st_size
    seconds_taken = time.perf_counter() - begin
    write_out(
        f"{name}: {count} frames, {count / fps:g} s, {megabytes:.2g} MB, made in {seconds_taken:.1f} s\n"
    )
