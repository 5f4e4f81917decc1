"""`render-animation`: a short film of the pair in mesh, as GIF or MP4."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from beveloid_geom.cli.options import (
    BUILTIN_DESIGN,
    NumberRange,
    Refusal,
    changed_design,
    flank_option,
    load_design,
    override_options,
    write_out,
)

from ..options import command, option, prepare_folder, require_drawing, size_option, writing

if TYPE_CHECKING:
    from .motion import Film

DEFAULT_OUT = Path("outputs/mesh.gif")
SUFFIXES = (".gif", ".mp4")
FEWEST = 2
"""Frames of a film."""


def check_format(out: Path, size: tuple[int, int], fps: float, seconds: float) -> str | None:
    """Give the encoder of an MP4, None for a GIF. Raises Refusal for what the format does not allow."""
    from .writer import HUNDREDTHS, INSTALL, encoder, gif_rates

    suffix = out.suffix.lower()
    if suffix not in SUFFIXES:
        raise Refusal([f"--out: {out.name} ends in neither .gif nor .mp4"])
    if out.is_dir():
        raise Refusal([f"--out: {click.format_filename(out)} is a folder: name a file in it"])
    if round(seconds * fps) < FEWEST:
        raise Refusal([f"--seconds {seconds:g} at --fps {fps:g} leaves less than {FEWEST} frames: take more"])
    if suffix == ".gif":
        if abs(HUNDREDTHS / fps - round(HUNDREDTHS / fps)) > 1e-6:
            near = sorted(gif_rates(), key=lambda rate: abs(rate - fps))[:2]
            rates = " or ".join(f"{rate:.4g}" for rate in sorted(near))
            raise Refusal([f"--fps {fps:g}: a GIF counts in hundredths of a second, take {rates}, or .mp4"])
        return None
    if any(side % 2 for side in size):
        raise Refusal([f"--size {size[0]}x{size[1]}: both sides of an MP4 must be even"])
    program = encoder()
    if program is None:
        raise Refusal([INSTALL])
    return program


def write_film(
    film: Film, out: Path, size: tuple[int, int], fps: float, pitches: int, program: str | None
) -> int:
    """Draw and write the frames; how many. Raises Refusal where the file cannot be written."""
    from tqdm import tqdm

    from beveloid_geom.support.whole_file import whole_file

    from . import page, writer

    count = pitches * len(film.motion.share)
    with (
        writing(click.format_filename(out), ": choose another with --out"),
        whole_file(out) as beside,
        tqdm(
            page.frames(film, size, pitches), desc="frames", total=count, unit="frame", file=sys.stderr
        ) as frames,
    ):
        if program is None:
            writer.write_gif(frames, beside, fps)
        else:
            writer.write_mp4(frames, beside, fps, program)
    return count


@command("render-animation")
@click.argument("design", default=BUILTIN_DESIGN)
@flank_option
@option("--out", click.Path(path_type=Path), DEFAULT_OUT, "The film, .gif or .mp4.", metavar="FILE")
@option("--pitches", click.IntRange(1, 100), 1, "Pitches of the pinion that pass; each is as the one before.")
@option("--seconds", NumberRange(0.1, 60.0), 3.0, "Time a pitch takes.", metavar="S")
@option(
    "--fps",
    NumberRange(1.0, 60.0),
    20.0,
    "Frames a second; in a GIF 100 over a whole number, up to 50.",
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
    **changes: float | None,
) -> None:
    """Write a short film of the pair in mesh, with the contact moving over the flanks.

    The gear stands where the first of all teeth, edges included, stops it: rigid teeth, no load. The
    film runs without a jump when it is repeated, as a GIF is. MP4 needs an encoder: pip install
    'beveloid-geom[film]', or ffmpeg. Exit status 1 without contact on the flanks.
    """
    program = check_format(out, size, fps, seconds)
    changed = changed_design(load_design(design), changes)
    begin = time.perf_counter()
    require_drawing()

    from .motion import NoFilmError, film_of

    try:
        film = film_of(changed, flank, round(seconds * fps), click.format_filename(design, shorten=True))
        prepare_folder(out.parent)
        count = write_film(film, out, size, fps, pitches, program)
    except NoFilmError as error:
        raise click.ClickException(f"no film: {error}") from None  # status 1
    told = f"{count} frames, {count / fps:g} s, {1e-6 * out.stat().st_size:.2g} MB"
    write_out(f"{click.format_filename(out)}: {told}, made in {time.perf_counter() - begin:.1f} s\n")
