"""Solids of the CAD kernel, Open CASCADE, from the faces of a gear, and their STEP files.

A `Strip` is a face from toe to heel. Strips follow each other around a closed `loop`, with the metal to their
left seen from +z. Neighbouring strips share an edge, and so do a strip and the end planes, so that the solid
is closed without sewing. Every edge has a curve in space and, for each curved surface next to it, a curve in
the parameters of this surface.

Only this module imports OCP (Open CASCADE 8). `step` imports it when there is something to write.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

import numpy as np
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRep import BRep_Builder
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_gp_Pnt2d, Array1_int, Array2_gp_Pnt
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Plane,
)
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Line
from OCP.gp import gp_Ax2, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pln, gp_Pnt, gp_Pnt2d, gp_Trsf
from OCP.IFSelect import IFSelect_RetDone
from OCP.Message import Message
from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPConstruct import STEPConstruct
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Shell, TopoDS_Solid, TopoDS_Vertex, TopoDS_Wire
from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_DocumentTool

from ..arrays import FloatArray
from ..contact.mesh_position import Frame
from .strips import Net, Revolved, SolidPart, Strip, StripEdge

PRECISION_MM = 1e-7
"""Precision of the kernel, to which edges and surfaces must agree."""
COLOURS = {
    "right flank": (0.27, 0.47, 0.67),
    "left flank": (0.93, 0.40, 0.47),
    "right fillet": (0.40, 0.80, 0.93),
    "left fillet": (0.93, 0.73, 0.40),
}
"""Red, green and blue of faces. All other faces are grey."""


NamedSolid: TypeAlias = tuple[TopoDS_Solid, list[tuple[str, TopoDS_Face]]]
"""Solid, and its faces with their names."""


def _array(kind: Any, values: Sequence[Any]) -> Any:
    array = kind(1, len(values))
    for i, value in enumerate(values, 1):
        array.SetValue(i, value)
    return array


def _knots(knots: FloatArray, poles: int) -> tuple[Any, Any, int]:
    """Return distinct knots, multiplicities and degree in the form of the kernel."""
    distinct, counts = np.unique(knots, return_counts=True)
    lengths = _array(Array1_double, distinct.tolist())
    return lengths, _array(Array1_int, counts.tolist()), len(knots) - poles - 1


def _point(point: FloatArray) -> gp_Pnt:
    return gp_Pnt(*point.tolist())


def _curve(knots: FloatArray, poles: FloatArray) -> Geom_BSplineCurve:
    points = _array(Array1_gp_Pnt, [_point(pole) for pole in poles])
    return Geom_BSplineCurve(points, *_knots(knots, len(poles)))


def _plane_curve(knots: FloatArray, poles: FloatArray) -> Geom2d_BSplineCurve:
    points = _array(Array1_gp_Pnt2d, [gp_Pnt2d(*pole) for pole in poles.tolist()])
    return Geom2d_BSplineCurve(points, *_knots(knots, len(poles)))


def _line(start: tuple[float, float], direction: tuple[float, float]) -> Geom2d_Line:
    return Geom2d_Line(gp_Pnt2d(*start), gp_Dir2d(*direction))


def _spline_surface(net: Net, edge: StripEdge) -> Geom_BSplineSurface:
    rows, columns = net.poles.shape[:2]
    poles = Array2_gp_Pnt(1, rows, 1, columns)
    for i, row in enumerate(net.poles.tolist(), 1):
        for j, pole in enumerate(row, 1):
            poles.SetValue(i, j, gp_Pnt(*pole))
    (u, mu, du), (v, mv, dv) = _knots(net.knots, rows), _knots(edge.knots, columns)
    return Geom_BSplineSurface(poles, u, v, mu, mv, du, dv)


def _vertex(builder: BRep_Builder, point: FloatArray) -> TopoDS_Vertex:
    vertex = TopoDS_Vertex()
    builder.MakeVertex(vertex, _point(point), PRECISION_MM)
    return vertex


def _edge(
    builder: BRep_Builder, curve: Any, ends: tuple[float, float], vertices: Sequence[TopoDS_Vertex]
) -> TopoDS_Edge:
    edge = TopoDS_Edge()
    builder.MakeEdge(edge, curve, PRECISION_MM)
    builder.Add(edge, vertices[0])
    builder.Add(edge, vertices[1].Oriented(TopAbs_REVERSED))
    builder.Range(edge, *ends)
    return edge


@dataclass(frozen=True, eq=False)
class _Placed:
    """Strip in the form of the kernel.

    `surface`; `arcs` at toe and heel with their `ranges`; `in_surface`: curves of toe, last edge, heel and
    first edge in the parameters of the surface. `inward` is whether the strip runs clockwise seen from +z,
    as in a bore. The normal of the surface then points into the metal."""

    surface: Any
    arcs: tuple[Any, Any]
    ranges: tuple[tuple[float, float], tuple[float, float]]
    in_surface: tuple[Any, Any, Any, Any]
    inward: bool


def _placed_net(strip: Strip, net: Net) -> _Placed:
    lines = (
        _line((0.0, 0.0), (1.0, 0.0)),
        _line((1.0, 0.0), (0.0, 1.0)),
        _line((0.0, 1.0), (1.0, 0.0)),
        _line((0.0, 0.0), (0.0, 1.0)),
    )
    arcs = _curve(net.knots, net.poles[:, 0]), _curve(net.knots, net.poles[:, -1])
    return _Placed(_spline_surface(net, strip.first), arcs, ((0.0, 1.0), (0.0, 1.0)), lines, False)


def _placed_revolved(strip: Strip, shape: Revolved) -> _Placed:
    """Return a strip of a cone or cylinder in the form of the kernel.

    The angular parameter starts on the opposite side of the axis, so that no strip crosses the seam of the
    surface. The axis points in the direction in which the cone widens, because STEP has no other cones. If
    the cone narrows towards +z, the axis therefore points to -z, and the sense of the angular parameter is
    reversed. On the arcs of a bore, the sense of the angular parameter is reversed, too."""
    angles = np.concatenate((strip.first.angle, strip.last.angle))
    seam = 0.5 * float(angles.min() + angles.max()) - np.pi
    x = gp_Dir(float(np.cos(seam)), float(np.sin(seam)), 0.0)
    up = -1.0 if shape.growth < 0.0 else 1.0
    inward = bool(strip.last.angle[0] < strip.first.angle[0])
    spin = -1.0 if inward else 1.0
    slope = float(np.arctan(abs(shape.growth)))
    axes = gp_Ax3(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 0.0, up), x)
    surface: Any
    if slope > 1e-12:  # rad
        surface = Geom_ConicalSurface(axes, slope, shape.radius)
    else:
        surface = Geom_CylindricalSurface(axes, shape.radius)

    def turned(angle: Any, sense: float) -> Any:
        return angle - seam if sense > 0.0 else 2.0 * np.pi - (angle - seam)

    def edge_curve(line: StripEdge) -> Geom2d_BSplineCurve:
        along = up * line.points[:, 2] / np.cos(slope)
        return _plane_curve(line.knots, np.stack((turned(line.angle, up), along), axis=-1))

    def arc(end: int) -> tuple[Geom_Circle, Geom2d_Line, tuple[float, float]]:
        """Return the arc at toe (0) or heel (-1), its line in the surface, and its range."""
        z = float(strip.first.points[end, 2])
        frame = gp_Ax2(gp_Pnt(0.0, 0.0, z), gp_Dir(0.0, 0.0, spin), x)
        start = 0.0 if up * spin > 0.0 else 2.0 * np.pi
        line = _line((start, up * z / np.cos(slope)), (up * spin, 0.0))
        ends = tuple(float(turned(edge.angle[end], spin)) for edge in (strip.first, strip.last))
        return Geom_Circle(frame, shape.radius + shape.growth * z), line, (ends[0], ends[1])

    (toe, on_toe, toe_range), (heel, on_heel, heel_range) = arc(0), arc(-1)
    in_surface = on_toe, edge_curve(strip.last), on_heel, edge_curve(strip.first)
    return _Placed(surface, (toe, heel), (toe_range, heel_range), in_surface, inward)


def _wire(builder: BRep_Builder, edges: Sequence[TopoDS_Edge], forward: Sequence[bool]) -> TopoDS_Wire:
    wire = TopoDS_Wire()
    builder.MakeWire(wire)
    for edge, ahead in zip(edges, forward, strict=True):
        builder.Add(wire, edge if ahead else edge.Reversed())
    wire.Closed(True)
    return wire


def _face_of(builder: BRep_Builder, placed: _Placed, edges: Sequence[TopoDS_Edge]) -> TopoDS_Face:
    """Return the face of a strip between its edges: at toe, last, at heel and first."""
    face = TopoDS_Face()
    builder.MakeFace(face, placed.surface, PRECISION_MM)
    for edge, curve in zip(edges, placed.in_surface, strict=True):
        builder.UpdateEdge(edge, curve, face, PRECISION_MM)
    wire = _wire(builder, edges, (True, True, False, False))
    builder.Add(face, wire.Reversed() if placed.inward else wire)
    return face.Reversed() if placed.inward else face


def _loop_faces(
    builder: BRep_Builder, loop: Sequence[Strip]
) -> tuple[list[TopoDS_Face], tuple[TopoDS_Wire, TopoDS_Wire]]:
    """Return the faces of a closed loop of strips and the wires that bound it at toe and heel."""
    corners = [[_vertex(builder, strip.first.points[end]) for end in (0, -1)] for strip in loop]
    lines = [
        _edge(builder, _curve(strip.first.knots, strip.first.points), (0.0, 1.0), ends)
        for strip, ends in zip(loop, corners, strict=True)
    ]
    faces: list[TopoDS_Face] = []
    rims: tuple[list[TopoDS_Edge], list[TopoDS_Edge]] = ([], [])
    for i, strip in enumerate(loop):
        j = (i + 1) % len(loop)
        shape = strip.surface
        placed = _placed_net(strip, shape) if isinstance(shape, Net) else _placed_revolved(strip, shape)
        for end in (0, 1):
            vertices = corners[i][end], corners[j][end]
            rims[end].append(_edge(builder, placed.arcs[end], placed.ranges[end], vertices))
        faces.append(_face_of(builder, placed, (rims[0][i], lines[j], rims[1][i], lines[i])))
    toe, heel = (_wire(builder, rim, [True] * len(rim)) for rim in rims)
    return faces, (toe, heel)


def solid_of(loops: Sequence[Sequence[Strip]]) -> NamedSolid:
    """Return the solid between two planes that is bounded by closed loops of strips, the outer loop first."""
    builder = BRep_Builder()
    named: list[tuple[str, TopoDS_Face]] = []
    rims = []
    for loop in loops:
        faces, wires = _loop_faces(builder, loop)
        named += [(_name(strip), face) for strip, face in zip(loop, faces, strict=True)]
        rims.append(wires)
    for end, name in ((0, "toe"), (1, "heel")):
        plane = gp_Pln(_point(loops[0][0].first.points[-end] * (0.0, 0.0, 1.0)), gp_Dir(0.0, 0.0, 1.0))
        face = TopoDS_Face()
        builder.MakeFace(face, Geom_Plane(plane), PRECISION_MM)
        for wires in rims:
            builder.Add(face, wires[end])
        named.append((name, face if end else face.Reversed()))
    shell, solid = TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    for _, face in named:
        builder.Add(shell, face)
    shell.Closed(True)
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    return solid, named


def _name(strip: Strip) -> str:
    return strip.name if strip.tooth is None else f"{strip.name} {strip.tooth}"


def write_solids(parts: Sequence[SolidPart], path: Path, name: str) -> None:
    """Write solids as STEP, mm, with the names of their faces.

    Solids with a frame are components of an assembly of the given `name`. Raises OSError if the file cannot
    be written, and RuntimeError if a solid is not valid in the kernel."""
    shapes = [solid_of(part.loops) for part in parts]
    for part, (solid, _) in zip(parts, shapes, strict=True):
        if not BRepCheck_Analyzer(solid).IsValid():
            raise RuntimeError(f"{part.name}: the CAD kernel rejects the solid: please report this design")
    with quiet_kernel():
        writer = STEPCAFControl_Writer()
        writer.Transfer(_document(parts, shapes, name))
        finder = writer.ChangeWriter().WS().TransferWriter().FinderProcess()
        for part, (solid, faces) in zip(parts, shapes, strict=True):
            for label, shape in [*faces, (part.name, solid)]:
                STEPConstruct.FindEntity_s(finder, shape).SetName(_text(label))
        _write_header(writer.ChangeWriter().Model(), name)
        with _path_in_utf8(path) as written:
            if writer.Write(str(written)) != IFSelect_RetDone:
                raise OSError("the CAD kernel could not write the file")


@contextmanager
def _path_in_utf8(path: Path) -> Iterator[Path]:
    """Yield a path in UTF-8, which the kernel requires; the file is copied from there to `path`."""
    try:
        str(path).encode("utf-8")
    except UnicodeEncodeError:
        with TemporaryDirectory() as folder:
            yield (temporary := Path(folder) / "solid.step")
            shutil.copyfile(temporary, path)
    else:
        yield path


def _document(parts: Sequence[SolidPart], shapes: Sequence[NamedSolid], name: str) -> TDocStd_Document:
    """Return the solids as products with their names and coloured faces.

    Those with a frame are components of one assembly, each in its position."""
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    products, colours = (
        tool(document.Main()) for tool in (XCAFDoc_DocumentTool.ShapeTool_s, XCAFDoc_DocumentTool.ColorTool_s)
    )
    grey = (0.75, 0.75, 0.75)
    placed = []
    for part, (solid, faces) in zip(parts, shapes, strict=True):
        product = products.AddShape(solid, False)
        _set_name(product, part.name)
        for label, face in faces:
            colour = Quantity_Color(*COLOURS.get(label.rstrip(" 0123456789"), grey), Quantity_TOC_sRGB)
            colours.SetColor(products.AddSubShape(product, face), colour, XCAFDoc_ColorSurf)
        if part.frame is not None:
            placed.append((part.name, product, _location(part.frame)))
    if placed:
        assembly = products.NewShape()
        _set_name(assembly, name)
        for label, product, place in placed:
            _set_name(products.AddComponent(assembly, product, place), label)
        products.UpdateAssemblies()
    return document


def _set_name(label: Any, name: str) -> None:
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))


def _location(frame: Frame) -> TopLoc_Location:
    """Return the position of the frame of a gear in the form of the kernel."""
    rotation, origin = frame
    place = gp_Trsf()
    place.SetValues(*np.column_stack((rotation, origin)).ravel().tolist())
    return TopLoc_Location(place)


@contextmanager
def quiet_kernel() -> Iterator[None]:
    """Suppress the progress reports of the kernel on standard output."""
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    messenger.ChangePrinters().Clear()
    try:
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)


def _write_header(model: Any, name: str) -> None:
    """Write the name and the originating system into the header."""
    header = APIHeaderSection_MakeHeader(model)
    header.SetName(_text(name))
    header.SetOriginatingSystem(_text("beveloid-geom"))
    header.SetAuthorValue(1, _text(""))
    header.SetOrganizationValue(1, _text(""))


def _text(text: str) -> TCollection_HAsciiString:
    return TCollection_HAsciiString(text)
