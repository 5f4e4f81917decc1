"""Entry points of the commands that draw."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from beveloid_geom.support.process import CANNOT_WRITE, leave, run, undoing


def _start(module: str) -> None:
    os.environ.setdefault(
        "OPENBLAS_NUM_THREADS", "1"
    )  # the matrix products are too small for several threads
    # Notebooks export their backend, which may not be installed here.
    os.environ["MPLBACKEND"] = "agg"
    with _matplotlib_folder():
        run(f"beveloid_viz.{module}")


@contextmanager
def _matplotlib_folder() -> Iterator[None]:
    """Set a temporary folder for Matplotlib's font list if its own folders are not writable."""
    if all(map(_writable, _own_folders())):
        yield
        return
    import shutil
    import tempfile

    try:
        folder = tempfile.mkdtemp(prefix="matplotlib-", dir=_temporary())
    except OSError as error:
        cure = "set the environment variable TMPDIR to a writable folder"
        leave(CANNOT_WRITE, f"no folder for temporary files ({error.strerror}): {cure}")

    def remove() -> str:
        shutil.rmtree(folder, ignore_errors=True)
        return ""

    os.environ["MPLCONFIGDIR"] = folder
    with undoing(remove):
        try:
            yield
        finally:
            remove()


def _own_folders() -> list[Path]:
    """Return Matplotlib's folders for settings and for its cache on Linux."""
    if given := os.environ.get("MPLCONFIGDIR"):
        return [Path(given)]
    home = Path(os.path.expanduser("~"))
    bases = (("XDG_CONFIG_HOME", ".config"), ("XDG_CACHE_HOME", ".cache"))
    return [Path(os.environ.get(variable) or home / name) / "matplotlib" for variable, name in bases]


def _writable(folder: Path) -> bool:
    """Create a folder, as Matplotlib does, and return whether it is writable."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK)


def _temporary() -> str:
    """Return the folder for temporary files. Containers with a read-only root have /dev/shm only."""
    import tempfile

    try:
        return tempfile.gettempdir()
    except FileNotFoundError:
        os.environ["TMPDIR"] = "/dev/shm"  # for worker processes, too
        tempfile.tempdir = None
        return tempfile.gettempdir()


def figures() -> None:
    """Run `render-figures`."""
    _start("cli")


def animation() -> None:
    """Run `render-animation`."""
    _start("film.cli")


def report() -> None:
    """Run `render-report`."""
    _start("report.cli")


def explore() -> None:
    """Run `explore-pair`."""
    _start("explore.cli")
