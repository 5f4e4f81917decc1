"""Where the commands of the pictures start."""

import os

from beveloid_geom.support.process import run


def _start(module: str) -> None:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its products are too small to be shared out
    run(f"beveloid_viz.{module}")


def figures() -> None:
    """Run `render-figures`."""
    _start("cli")


def animation() -> None:
    """Run `render-animation`."""
    _start("film.cli")


def report() -> None:
    """Run `render-report`."""
    _start("report.cli")
