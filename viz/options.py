"""Options, checks and error messages shared by the commands that draw."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click

from beveloid_geom.cli.options import (
    OneLineCommand,
    Option,
    Refusal,
    option as option,
    version_option,
)
from beveloid_geom.support.process import undoing

DEFAULT_PROCESSES = 4
"""Largest default number of processes; each takes about 0.4 GB."""


class NoOpenGL(click.ClickException):
    """Error if this machine cannot draw: one line, exit status 3."""

    exit_code = 3


def page_size(value: str) -> tuple[int, int]:
    """Return width and height of a page size such as 1600x1200. Raises BadParameter."""
    match = re.fullmatch(r"(\d+)[xX](\d+)", value)
    if not match:
        raise click.BadParameter(f"{value!r} is not a size: write it as 1600x1200")
    width, height = int(match[1]), int(match[2])
    # Smallest and largest side of a page, pixels.
    smallest_side_px, largest_side_px = 200, 8000
    if not all(smallest_side_px <= side <= largest_side_px for side in (width, height)):
        raise click.BadParameter(
            f"{value!r} is out of range: sides are {smallest_side_px} to {largest_side_px} pixels"
        )
    return width, height


def usable_cores() -> int:
    """Return the number of cores available to this process, at most DEFAULT_PROCESSES."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on all systems
    return min(len(affinity(0)) if affinity else os.cpu_count() or 1, DEFAULT_PROCESSES)


def command(name: str) -> Callable[[Callable[..., Any]], click.Command]:
    """Return a decorator for a command `name` with `-h` and `--version`."""
    made = click.command(cls=OneLineCommand, context_settings={"help_option_names": ["-h", "--help"]})
    return lambda function: made(version_option(name)(function))


def size_option(default: str) -> Option:
    """Return the option `--size`."""
    return option("--size", page_size, default, "Size in pixels.", metavar="WxH")


def require_drawing() -> None:
    """Check that OpenGL draws off screen. Raises NoOpenGL."""
    from .rendering.opengl import MissingOpenGLError, require_opengl

    try:
        require_opengl()
    except MissingOpenGLError as error:
        raise NoOpenGL(str(error)) from None


@contextmanager
def _output_folder(path: Path) -> Iterator[None]:
    """Create a writable folder. New folders are removed at the end if they are empty."""
    new = [folder for folder in (path, *path.parents) if not os.path.exists(folder)]

    def remove_empty() -> str:
        """Remove the new folders that are empty; return no message for the user."""
        for folder in new:
            with suppress(OSError):
                folder.rmdir()
        return ""

    with undoing(remove_empty):
        try:
            path.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=path):
                pass
            yield
        finally:
            remove_empty()


def prepare_folder(path: Path) -> None:
    """Create the output folder and check that it is writable. New folders that are empty at the end of the
    command are removed. Raises Refusal."""
    try:
        click.get_current_context().with_resource(_output_folder(path))
    except OSError as error:
        raise Refusal([f"cannot write to {path} ({error.strerror}): choose a folder with --out"]) from None


@contextmanager
def writing(what: str, cure: str = "") -> Iterator[None]:
    """Raise Refusal for system errors while `what` is written; `cure` may name a solution."""
    try:
        yield
    except OSError as error:
        raise Refusal([f"cannot write {what} ({error.strerror or error}){cure}"]) from None
