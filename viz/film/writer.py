"""Frames into a file: GIF by Pillow, MP4 by ffmpeg."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from functools import partial
from itertools import chain
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from beveloid_geom.support.process import undoing

Image = NDArray[np.uint8]
INSTALL = "MP4 files need an encoder: pip install 'beveloid-geom[film]', or take .gif"
COLOURS = 255
"""Of the palette: one more stands for what has not changed since the frame before."""
NEARLY_WHITE = 248
"""Levels of red, green and blue from which a colour of the palette is made white."""
HUNDREDTHS = 100
"""A GIF counts time in hundredths of a second; viewers slow down what takes less than two."""
QUALITY = "18"
"""x264's constant rate factor: no loss that is seen."""
BT709 = ("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709")


def gif_rates() -> list[float]:
    """Give frames per second that a GIF can have."""
    return [HUNDREDTHS / delay for delay in range(2, HUNDREDTHS + 1)]


def write_gif(frames: Iterable[Image], path: Path, fps: float) -> None:
    """Write an endless GIF of frames (height, width, 3), of the colours of the first. Raises OSError."""
    images = iter(frames)
    first = next(images)
    palette = palette_of(first)
    # Dithered metal would flicker and be many times as large; in 255 colours of its own it shows no bands.
    reduced = (
        Pillow.fromarray(image).quantize(palette=palette, dither=Pillow.Dither.NONE)
        for image in chain([first], images)
    )
    settings = {"duration": round(1000.0 / fps), "loop": 0, "disposal": 1}
    next(reduced).save(path, format="GIF", save_all=True, append_images=reduced, **settings)


def palette_of(image: Image) -> Pillow.Image:
    """Give an image in the colours that suit `image`, white as white among them."""
    reduced = Pillow.fromarray(image).quantize(COLOURS, Pillow.Quantize.MEDIANCUT, kmeans=1)
    colours = np.array(reduced.getpalette(), dtype=int).reshape(-1, 3)
    colours[(colours >= NEARLY_WHITE).all(axis=1)] = 255
    reduced.putpalette(colours.astype(np.uint8).tobytes())
    return reduced


def encoder() -> str | None:
    """Find the ffmpeg that comes with imageio-ffmpeg, or else that of the system; None without any."""
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return shutil.which("ffmpeg")


def write_mp4(frames: Iterable[Image], path: Path, fps: float, program: str) -> None:
    """Write H.264 that browsers play, by ffmpeg, of frames (height, width, 3) with even sides. Raises
    OSError, with ffmpeg's last words where it fails."""
    images: Iterator[Image] = iter(frames)
    first = next(images)
    height, width = first.shape[:2]
    command = [program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-", "-an", "-c:v", "libx264"]
    command += ["-vf", "scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p", *BT709]
    command += ["-crf", QUALITY, "-preset", "slow", "-movflags", "+faststart", "-f", "mp4", str(path)]
    with tempfile.TemporaryFile() as words:
        # A session of its own, so that Ctrl-C does not reach it and it says nothing: it is ended here.
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=words, start_new_session=True)
        assert process.stdin is not None
        try:
            with undoing(partial(_ended, process)), process.stdin as pipe:
                for image in chain([first], images):
                    pipe.write(np.ascontiguousarray(image).data)
        except BrokenPipeError:
            pass  # it says itself what it did not like
        except BaseException:
            _ended(process)
            raise
        if process.wait():
            raise OSError(f"ffmpeg: {_last_line(words) or f'exit status {process.returncode}'}")


def _ended(process: subprocess.Popen[bytes]) -> str:
    """End the encoder; nothing to be said of it."""
    process.kill()
    process.wait()
    return ""


def _last_line(words: IO[Any]) -> str:
    words.seek(0)
    lines = words.read().decode(errors="replace").strip().splitlines()
    return str(lines[-1]) if lines else ""
