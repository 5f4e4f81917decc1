"""A gear as one solid for CAD, or the pair as an assembly of two: a STEP file (AP214, mm).

The faces, as `strips` makes them, are named for their tooth, counted from 1 at angle 0: 'right flank 1',
'tip 1' ...; a bottom land has the number of the tooth before it. The names stand in the file; readers
built on Open CASCADE give them where they ask for names of parts of a shape, which FreeCAD and Gmsh do
not. These show the colours instead, one for each kind of surface, and the name of the product.

Needs OCP, the Python bindings of Open CASCADE 8: pip install 'beveloid-geom[step]'.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from ..contact.placing import Frame
from ..design.model import Design, Member
from ..export import MEMBERS
from ..support.whole_file import whole_file
from .strips import Part, gear_loops

INSTALL = "STEP files need Open CASCADE: pip install 'beveloid-geom[step]'"
LIBRARIES = "on Debian and Ubuntu `sudo apt-get install libgl1` brings it"


def write_step(
    member: Member,
    path: Path | str,
    tooth_numbers: Sequence[int] | None = None,
    bore_radius: float | None = None,
    name: str = "gear",
    frame: Frame | None = None,
) -> None:
    """Write the whole gear, or the neighbouring teeth of the `tooth_numbers` (0 is at angle 0), as one
    solid in the own frame of a single member; the `bore_radius` (mm) is 0.45 of the root radius if None. The
    product has the `name`, with the count of teeth where they are not all. With a `frame` it is the only
    component of an assembly, and stands there as the frame says.

    Part of a gear is cut in the middle of the tooth spaces beside it. Raises ValueError for an
    undercut member, a pointed tooth, a pointed tool, a bore out of its limits, teeth that are no
    neighbours or wind round the gear; ModuleNotFoundError without OCP; OSError where the file cannot be
    written."""
    write_solids = _kernel()
    loops = gear_loops(member, tooth_numbers, bore_radius)
    count, total = sum(strip.name == "tip" for strip in loops[0]), int(member.teeth)
    own = name if count == total else f"{name}, {count} of {total} teeth"
    with whole_file(Path(path)) as unfinished:
        write_solids([Part(own, loops, frame)], unfinished, own)


def write_step_pair(design: Design, path: Path | str, frames: Sequence[Frame]) -> None:
    """Write both whole gears of a single design as products 'pinion' and 'gear' of an assembly 'pair', each
    where its frame of `frames` (2) carries it. Raises as `write_step` does."""
    write_solids = _kernel()
    parts = [
        Part(name, gear_loops(member), frame)
        for name, member, frame in zip(MEMBERS, design.members, frames, strict=True)
    ]
    with whole_file(Path(path)) as unfinished:
        write_solids(parts, unfinished, "pair")


def _kernel() -> Callable[[Sequence[Part], Path, str], None]:
    """Give the function that writes solids. Raises ImportError that says how to install what is not there."""
    with _kernel_errors():
        import OCP  # noqa: F401

        from ._brep import write_solids
    return write_solids


@contextmanager
def _kernel_errors() -> Iterator[None]:
    """Say how to install what is not there, the bindings or the system's libraries under them.

    An interrupt that the kernel's bindings met while they were imported, and turned into an ImportError,
    becomes one again."""
    try:
        yield
    except ImportError as error:
        cause: BaseException | None = error
        while cause is not None:
            if isinstance(cause, KeyboardInterrupt):
                raise KeyboardInterrupt from None
            cause = cause.__cause__ or cause.__context__
        if isinstance(error, ModuleNotFoundError) and (error.name or "").partition(".")[0] == "OCP":
            raise ModuleNotFoundError(INSTALL, name=error.name) from None
        if "cannot open shared object file" in str(error):  # servers and containers have no screen
            raise ImportError(f"Open CASCADE cannot be loaded: {error}: {LIBRARIES}") from None
        raise
