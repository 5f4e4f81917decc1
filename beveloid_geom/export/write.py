"""One function that writes every kind of geometry by the suffix of the file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from ..export import CAD_FORMATS, SCENE_FORMATS, SURFACE_FORMATS, VOLUME_FORMATS, writer_of
from ..support.atomic_file import atomic_file

if TYPE_CHECKING:
    from ..design.member import Member
    from ..shapes.hexahedral_mesh import VolumeMesh
    from ..shapes.sampling import FlankGrid
    from ..shapes.solid import Solid
    from ..shapes.surface_mesh import TriangleMesh
    from .scene import SceneItem
    from .surfaces import SurfaceMesh

    Geometry: TypeAlias = (
        SurfaceMesh | TriangleMesh | Solid | FlankGrid | VolumeMesh | Member | Sequence[SceneItem]
    )


def write(obj: Geometry, path: Path | str) -> None:
    """Write geometry to a file in the format of its suffix.

    The file is written completely or not at all. Lengths are mm, in metres in .glb.

    Parameters
    ----------
    obj : Solid, FlankGrid, TriangleMesh, SurfaceMesh, VolumeMesh, Member or sequence of SceneItem
        A solid (`gear_solid`), a sampled flank (`sample_flank`), a surface (`gear_mesh`, `gear_surface`)
        or hexahedra (`tooth_hexahedra`); the items of a scene (`pair_scene`); or a member, which is written
        as a complete gear for CAD.
    path : Path or str
        File to write. Suffixes of surfaces are .stl, .ply, .obj, .3mf, .vtk, .vtp and .vtu, of hexahedra
        .inp, .msh, .bdf and .vtu, of a member .step and .stp, of a scene .glb.

    Raises
    ------
    TypeError
        If there is no writer for such an object.
    ValueError
        If the suffix is not one of its formats.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import os, tempfile
    >>> import beveloid_geom as bg
    >>> grid = bg.sample_flank(bg.builtin_design().pinion, "right", 0.05)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     bg.write(grid, folder + "/flank.vtp")
    ...     os.listdir(folder)
    ['flank.vtp']
    """
    path = Path(path)
    suffix = path.suffix.lower()
    # Resolve the writer before anything is computed, so that a wrong suffix is reported at once.
    write_to = _writer(obj, suffix)
    with atomic_file(path) as unfinished:
        write_to(unfinished)


def _writer(obj: Geometry, suffix: str) -> Callable[[Path], None]:
    """Return the function that writes `obj` to a path. Raises TypeError and ValueError as `write`."""
    from ..design.member import Member
    from ..shapes.hexahedral_mesh import VolumeMesh
    from .scene import SceneItem

    if isinstance(obj, Member):
        write_member = writer_of(CAD_FORMATS, suffix)
        return lambda path: write_member(obj, path)
    if isinstance(obj, VolumeMesh):
        from .fea.volumes import write_volume

        element = {20: "C3D20", 8: "C3D8"}[obj.hexahedra.shape[1]]
        writer_of(VOLUME_FORMATS, suffix)
        return lambda path: write_volume(obj, path, element, suffix=suffix)
    if isinstance(obj, Sequence) and obj and all(isinstance(item, SceneItem) for item in obj):
        write_scene = writer_of(SCENE_FORMATS, suffix)
        return lambda path: write_scene(obj, path)
    from .surfaces import write_surface

    surface = _surface(obj)
    writer_of(SURFACE_FORMATS, suffix)
    return lambda path: write_surface(surface, path, suffix)


def _surface(obj: Geometry) -> SurfaceMesh:
    """Return the triangles of a surface, a solid or a flank. Raises TypeError for other objects."""
    from ..shapes.sampling import FlankGrid
    from ..shapes.solid import NAMES, Solid
    from ..shapes.surface_mesh import TriangleMesh
    from .parts import flank_triangles
    from .surfaces import SurfaceMesh

    if isinstance(obj, SurfaceMesh):
        return obj
    if isinstance(obj, FlankGrid):
        return flank_triangles(obj)
    if isinstance(obj, Solid):
        return SurfaceMesh(obj.points, obj.faces, {}, {"part": obj.part}, obj.names)
    if isinstance(obj, TriangleMesh):
        return SurfaceMesh(obj.points, obj.faces, {"normals": obj.normals}, {"part": obj.part}, NAMES)
    raise TypeError(
        f"cannot write a {type(obj).__name__}: pass a solid, a flank grid, a surface, hexahedra, a member or "
        "the items of a scene"
    )
