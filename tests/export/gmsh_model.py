"""Files opened by Gmsh's own library; tests without it are skipped."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest


@contextmanager
def opened_in_gmsh(path: Path) -> Iterator[Any]:
    """Open a file, and give the library."""
    gmsh = pytest.importorskip("gmsh", reason="pip install gmsh")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        yield gmsh
    finally:
        gmsh.finalize()
        # Gmsh restores the default action of SIGPIPE, with which a broken pipe would end the test.
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
