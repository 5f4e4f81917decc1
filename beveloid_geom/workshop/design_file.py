"""Design files with everything that they may refer to: errors at the mesh and files of measured points."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from pathlib import Path

from ..design.deviations import FlankDeviations
from ..design.file import read_design_file
from ..design.member import Member
from ..design.model import Design
from ..design.modification_file import DeviationFile
from ..pair.misalignment_at_mesh import from_mesh


def read_design(path: str | PathLike[str]) -> Design:
    """Read a design file (TOML, mm and degrees), with errors about the common perpendicular or at the mesh,
    and with files of measured points.

    Parameters
    ----------
    path : path-like
        The file, or the name of a built-in design such as 'ni-2017'. Paths of measured points are relative to
        this file.

    Returns
    -------
    Design
        In mm and rad, with its errors about the common perpendicular.

    Raises
    ------
    DesignError
        With all faults of the file, or with the reason why it cannot be read.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> bg.read_design("ni-2017").gear.teeth
    45
    """
    return read_design_file(path, from_mesh, read_flank_deviations)


def read_flank_deviations(member: Member, source: DeviationFile) -> FlankDeviations:
    """Return the deviations of measured points from the flanks of a member.

    Parameters
    ----------
    member : Member
        A single member. The grid of the points lies on its flanks, with their parabolas and modifications.
    source : DeviationFile

    Returns
    -------
    FlankDeviations

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the file does not fit the grid, and as in `measuring_grid`.
    """
    from .grid import border_of, measuring_grid
    from .measured import read_deviations

    _, share, length = border_of(source.border)
    grid = measuring_grid(member, source.rows, source.columns, share, length)
    path = Path(source.file).resolve()
    deviations = read_deviations(path, grid).on_flanks
    return replace(deviations, file=str(path), border=source.border, nominal=member.nominal())
