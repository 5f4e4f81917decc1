"""STEP files (AP214, mm): a gear or some teeth as one solid, or the pair as an assembly of two solids.

Faces are named for their tooth, counted from 1 at angle 0: 'right flank 1', 'tip 1'. A bottom land has the
number of the tooth before it. Programs that are based on Open CASCADE can read the names of faces as names of
parts of a shape; FreeCAD and Gmsh do not. They show the name of the product and the colours, one for each
kind of surface.

The module needs OCP, the Python bindings of Open CASCADE 8: pip install 'beveloid-geom[step]'.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ..arrays import MEMBERS
from ..contact.mesh_position import Frame
from ..design.member import Member
from ..design.model import Design
from ..support.atomic_file import atomic_file
from .strips import SolidPart, gear_loops


def write_step(
    member: Member,
    path: Path | str,
    tooth_numbers: Sequence[int] | None = None,
    bore_radius: float | None = None,
    name: str = "gear",
    frame: Frame | None = None,
) -> None:
    """Write a gear, or some teeth of it, as one solid.

    Parameters
    ----------
    member : Member
        A single member.
    path : Path or str
        File to write.
    tooth_numbers : sequence of int, optional
        Neighbouring teeth; tooth 0 is at angle 0. All teeth by default. A part of a gear is cut in the middle
        of the tooth spaces next to it.
    bore_radius : float, optional
        mm; 0.45 of the root radius by default.
    name : str
        Name of the product. The number of teeth is appended if these are not all.
    frame : Frame, optional
        Position of the gear in S_f. The solid is then the only component of an assembly.

    Raises
    ------
    ValueError
        For a flank that undercut removes in a part of the face, a pointed tooth, a pointed tool, a bore
        outside its limits, teeth that are not neighbours, and a tooth that winds around the complete gear.
    ImportError
        If OCP is not installed or cannot be loaded.
    OSError
        If the file cannot be written.
    """
    write_solids = _kernel()
    loops = gear_loops(member, tooth_numbers, bore_radius)
    count, total = sum(strip.name == "tip" for strip in loops[0]), int(member.teeth)
    product = name if count == total else f"{name}, {count} of {total} teeth"
    with atomic_file(Path(path)) as unfinished:
        write_solids([SolidPart(product, loops, frame)], unfinished, product)


def write_step_pair(
    design: Design,
    path: Path | str,
    frames: Sequence[Frame],
    bore_radii: Sequence[float | None] = (None, None),
) -> None:
    """Write both gears of a single design as products 'pinion' and 'gear' of an assembly 'pair'.

    Parameters
    ----------
    design : Design
        A single design.
    path : Path or str
        File to write.
    frames : sequence of 2 frames
        Positions of pinion and gear in S_f.
    bore_radii : sequence of 2 float, optional
        Bore radii of pinion and gear, mm; see `write_step`.

    Raises
    ------
    ValueError, ImportError, OSError
        As `write_step`.
    """
    write_solids = _kernel()
    parts = [
        SolidPart(name, gear_loops(member, bore_radius=bore), frame)
        for name, member, frame, bore in zip(MEMBERS, design.members, frames, bore_radii, strict=True)
    ]
    with atomic_file(Path(path)) as unfinished:
        write_solids(parts, unfinished, "pair")


def _kernel() -> Callable[[Sequence[SolidPart], Path, str], None]:
    """Return the function that writes solids.

    Raises ImportError with the installation command of a missing package or system library. A
    KeyboardInterrupt during the import, which the bindings turn into an ImportError, is raised again."""
    install = "STEP files need Open CASCADE: pip install 'beveloid-geom[step]'"
    libraries = "on Debian and Ubuntu, run `sudo apt-get install libgl1`"
    without_vtk = "replace the package cadquery-ocp by cadquery-ocp-novtk, which needs no VTK"
    try:
        import OCP  # noqa: F401

        from ._brep import write_solids
    except ImportError as error:
        cause: BaseException | None = error
        while cause is not None:
            if isinstance(cause, KeyboardInterrupt):
                raise KeyboardInterrupt from None
            cause = cause.__cause__ or cause.__context__
        if isinstance(error, ModuleNotFoundError) and (error.name or "").partition(".")[0] == "OCP":
            raise ModuleNotFoundError(install, name=error.name) from None
        if "cannot open shared object file" in str(error):  # servers and containers without a screen
            cure = without_vtk if "libvtk" in str(error) else libraries
            raise ImportError(f"Open CASCADE cannot be loaded: {error}: {cure}") from None
        raise
    return write_solids
