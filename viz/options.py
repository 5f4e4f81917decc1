"""What the commands of the pictures share: options, checks before anything is computed, and refusals."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from beveloid_geom.cli.options import Option, Refusal, option as option, version_option

SMALLEST, LARGEST = 200, 8000
"""Pixels of a side of a page."""
MOST_UNASKED = 4
"""Processes that are started unasked: each takes about 0.4 GB."""


class NoOpenGL(click.ClickException):
    """Nothing can be drawn on this machine: one line, exit status 3."""

    exit_code = 3


class PageSize(click.ParamType[tuple[int, int]]):
    """A page size in pixels, such as 1600x1200."""

    name = "WxH"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Give width and height."""
        match = re.fullmatch(r"(\d+)[xX](\d+)", str(value))
        if not match:
            self.fail(f"{value!r} is not a size: write it as 1600x1200", param, ctx)
        width, height = int(match[1]), int(match[2])
        if not all(SMALLEST <= side <= LARGEST for side in (width, height)):
            self.fail(f"{value!r} is out of range: sides are {SMALLEST} to {LARGEST} pixels", param, ctx)
        return width, height


def usable_cores() -> int:
    """Count the cores that this process may use, up to MOST_UNASKED."""
    affinity = getattr(os, "sched_getaffinity", None)  # not on all systems
    return min(len(affinity(0)) if affinity else os.cpu_count() or 1, MOST_UNASKED)


def command(name: str) -> Callable[[Callable[..., Any]], click.Command]:
    """Make a command with `-h` and `--version`, called `name`."""
    made = click.command(context_settings={"help_option_names": ["-h", "--help"]})
    return lambda function: made(version_option(name)(function))


def size_option(default: str) -> Option:
    """Add option `--size`."""
    return option("--size", PageSize(), default, "Size in pixels.")


def require_drawing() -> None:
    """See that OpenGL draws off screen. Raises NoOpenGL."""
    from .stage.opengl import MissingOpenGLError, require_opengl

    try:
        require_opengl()
    except MissingOpenGLError as error:
        raise NoOpenGL(str(error)) from None


def prepare_folder(path: Path) -> None:
    """Make the output folder and see that it can be written to."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise Refusal([f"cannot write to {path} ({error.strerror}): choose a folder with --out"]) from None


@contextmanager
def writing(what: str, cure: str = "") -> Iterator[None]:
    """Refuse, while `what` is written, what the system refuses; `cure` says what may help."""
    try:
        yield
    except OSError as error:
        raise Refusal([f"cannot write {what} ({error.strerror or error}){cure}"]) from None
