"""A gear as one solid for CAD: a STEP file (AP214, mm).

The faces, as `strips` makes them, are named for their tooth: 'right flank 0', 'tip 0' ...; a
bottom land has the number of the tooth before it.

Needs OCP, the Python bindings of Open CASCADE 8: pip install 'beveloid-geom[step]'.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..inputs import Member
from ..whole_file import whole_file
from .strips import gear_loops

INSTALL = "STEP files need Open CASCADE: pip install 'beveloid-geom[step]'"


def write_step(
    member: Member, path: Path | str, teeth: Sequence[int] | None = None, bore_radius: float | None = None
) -> None:
    """Write the whole gear, or the neighbouring `teeth` numbered (0 is at angle 0), as one solid in
    the own frame of a single member; the `bore_radius` (mm) is 0.45 of the root radius if None.

    Part of a gear is cut in the middle of the tooth spaces beside it. Raises ValueError for an
    undercut member, a pointed tooth, a pointed tool, a bore that is too large, teeth that are no
    neighbours or wind round the gear; ImportError without OCP; OSError where the file cannot be
    written."""
    try:
        import OCP  # noqa: F401
    except ImportError:
        raise ImportError(INSTALL) from None
    from ._brep import write_solid

    loops = gear_loops(member, teeth, bore_radius)
    count = sum(strip.name == "tip" for strip in loops[0])
    with whole_file(Path(path)) as unfinished:
        write_solid(loops, f"beveloid gear, {count} of {int(member.teeth)} teeth", unfinished)
