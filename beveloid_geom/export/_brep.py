"""Solids of the CAD kernel, Open CASCADE, from the surfaces of a gear, and their STEP files.

A `Strip` is a surface from toe to heel; strips follow each other round a closed `loop`, the metal
on their left seen from +z. Neighbours have one edge in common, and so have a strip and the end
planes, which makes the solid closed by construction; nothing is sewn. Every edge holds its
curve in space and, for each curved surface beside it, in that surface's parameters.

Only this module imports OCP (OCCT 8). `step` imports it when it has something to write.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
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
from ..contact.placing import Frame
from .strips import Net, Part, Revolved, Strip, Trace

PRECISION = 1e-7
"""mm. The kernel's own; edges and surfaces must agree to it."""
COLOURS = {
    "right flank": (0.27, 0.47, 0.67),
    "left flank": (0.93, 0.40, 0.47),
    "right fillet": (0.40, 0.80, 0.93),
    "left fillet": (0.93, 0.73, 0.40),
}
"""Red, green and blue of faces; the others are GREY."""
GREY = (0.75, 0.75, 0.75)
STRAIGHT = 1e-12
"""Cone angles (rad) below which a surface of revolution is a cylinder."""


NamedSolid: TypeAlias = tuple[TopoDS_Solid, list[tuple[str, TopoDS_Face]]]
"""A solid and its faces with their names."""


def _array(kind: Any, values: Sequence[Any]) -> Any:
    array = kind(1, len(values))
    for i, value in enumerate(values, 1):
        array.SetValue(i, value)
    return array


def _knots(knots: FloatArray, poles: int) -> tuple[Any, Any, int]:
    """Find knots, multiplicities and degree as the kernel takes them."""
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


def _spline_surface(net: Net, trace: Trace) -> Geom_BSplineSurface:
    rows, columns = net.poles.shape[:2]
    poles = Array2_gp_Pnt(1, rows, 1, columns)
    for i, row in enumerate(net.poles.tolist(), 1):
        for j, pole in enumerate(row, 1):
            poles.SetValue(i, j, gp_Pnt(*pole))
    (u, mu, du), (v, mv, dv) = _knots(net.knots, rows), _knots(trace.knots, columns)
    return Geom_BSplineSurface(poles, u, v, mu, mv, du, dv)


def _vertex(builder: BRep_Builder, point: FloatArray) -> TopoDS_Vertex:
    vertex = TopoDS_Vertex()
    builder.MakeVertex(vertex, _point(point), PRECISION)
    return vertex


def _edge(
    builder: BRep_Builder, curve: Any, ends: tuple[float, float], vertices: Sequence[TopoDS_Vertex]
) -> TopoDS_Edge:
    edge = TopoDS_Edge()
    builder.MakeEdge(edge, curve, PRECISION)
    builder.Add(edge, vertices[0])
    builder.Add(edge, vertices[1].Oriented(TopAbs_REVERSED))
    builder.Range(edge, *ends)
    return edge


@dataclass(frozen=True, eq=False)
class _Placed:
    """A strip in the kernel's terms: its surface; its arcs at toe and heel, with their ranges; and
    in the surface's parameters the curves of the toe, last trace, heel and first trace. `inward`
    if the strip runs against the first parameter of the surface, whose own normal points in."""

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
    """Place a strip of a cone or cylinder. Angles count from its far side, so that nothing crosses the
    seam; the axis points to where the cone widens, as STEP knows no other cones. Both turn the
    other way round: the cone's angle where it narrows towards the heel, the arcs' in a bore."""
    angles = np.concatenate((strip.first.angle, strip.last.angle))
    seam = 0.5 * float(angles.min() + angles.max()) - np.pi
    x = gp_Dir(float(np.cos(seam)), float(np.sin(seam)), 0.0)
    up = -1.0 if shape.growth < 0.0 else 1.0
    inward = bool(strip.last.angle[0] < strip.first.angle[0])
    spin = -1.0 if inward else 1.0
    slope = float(np.arctan(abs(shape.growth)))
    axes = gp_Ax3(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 0.0, up), x)
    surface: Any
    if slope > STRAIGHT:
        surface = Geom_ConicalSurface(axes, slope, shape.radius)
    else:
        surface = Geom_CylindricalSurface(axes, shape.radius)

    def turned(angle: Any, sense: float) -> Any:
        return angle - seam if sense > 0.0 else 2.0 * np.pi - (angle - seam)

    def trace(line: Trace) -> Geom2d_BSplineCurve:
        along = up * line.points[:, 2] / np.cos(slope)
        return _plane_curve(line.knots, np.stack((turned(line.angle, up), along), axis=-1))

    def arc(end: int) -> tuple[Geom_Circle, Geom2d_Line, tuple[float, float]]:
        """Give the arc at toe (0) or heel (-1), its line in the surface, and its range."""
        z = float(strip.first.points[end, 2])
        frame = gp_Ax2(gp_Pnt(0.0, 0.0, z), gp_Dir(0.0, 0.0, spin), x)
        start = 0.0 if up * spin > 0.0 else 2.0 * np.pi
        line = _line((start, up * z / np.cos(slope)), (up * spin, 0.0))
        ends = tuple(float(turned(trace.angle[end], spin)) for trace in (strip.first, strip.last))
        return Geom_Circle(frame, shape.radius + shape.growth * z), line, (ends[0], ends[1])

    (toe, on_toe, toe_range), (heel, on_heel, heel_range) = arc(0), arc(-1)
    in_surface = on_toe, trace(strip.last), on_heel, trace(strip.first)
    return _Placed(surface, (toe, heel), (toe_range, heel_range), in_surface, inward)


def _wire(builder: BRep_Builder, edges: Sequence[TopoDS_Edge], forward: Sequence[bool]) -> TopoDS_Wire:
    wire = TopoDS_Wire()
    builder.MakeWire(wire)
    for edge, ahead in zip(edges, forward, strict=True):
        builder.Add(wire, edge if ahead else edge.Reversed())
    wire.Closed(True)
    return wire


def _face_of(builder: BRep_Builder, placed: _Placed, edges: Sequence[TopoDS_Edge]) -> TopoDS_Face:
    """Give the face of a strip between its edges at toe, last trace, heel and first trace."""
    face = TopoDS_Face()
    builder.MakeFace(face, placed.surface, PRECISION)
    for edge, curve in zip(edges, placed.in_surface, strict=True):
        builder.UpdateEdge(edge, curve, face, PRECISION)
    wire = _wire(builder, edges, (True, True, False, False))
    builder.Add(face, wire.Reversed() if placed.inward else wire)
    return face.Reversed() if placed.inward else face


def _loop_faces(
    builder: BRep_Builder, loop: Sequence[Strip]
) -> tuple[list[TopoDS_Face], tuple[TopoDS_Wire, TopoDS_Wire]]:
    """Give the faces of a closed loop of strips and the wires that bound it at toe and heel."""
    corners = [[_vertex(builder, strip.first.points[end]) for end in (0, -1)] for strip in loop]
    traces = [
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
        faces.append(_face_of(builder, placed, (rims[0][i], traces[j], rims[1][i], traces[i])))
    toe, heel = (_wire(builder, rim, [True] * len(rim)) for rim in rims)
    return faces, (toe, heel)


def solid_of(loops: Sequence[Sequence[Strip]]) -> NamedSolid:
    """Give the solid between two planes bounded by closed loops of strips, the outer one first, and its
    faces with their names."""
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
        builder.MakeFace(face, Geom_Plane(plane), PRECISION)
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


def write_solids(parts: Sequence[Part], path: Path, name: str) -> None:
    """Write solids as STEP, mm, with the names of their faces; those with a frame as components of an
    assembly of that `name`. Raises OSError, or RuntimeError where the kernel finds fault with a solid."""
    shapes = [solid_of(part.loops) for part in parts]
    for part, (solid, _) in zip(parts, shapes, strict=True):
        if not BRepCheck_Analyzer(solid).IsValid():
            raise RuntimeError(f"{part.name}: the kernel finds fault with the solid, please report it")
    with quiet_kernel():
        writer = STEPCAFControl_Writer()
        writer.Transfer(_document(parts, shapes, name))
        finder = writer.ChangeWriter().WS().TransferWriter().FinderProcess()
        for part, (solid, faces) in zip(parts, shapes, strict=True):
            for own, shape in [*faces, (part.name, solid)]:
                STEPConstruct.FindEntity_s(finder, shape).SetName(_text(own))
        _sign(writer.ChangeWriter().Model(), name)
        if writer.Write(str(path)) != IFSelect_RetDone:
            raise OSError("the CAD kernel could not write it")


def _document(parts: Sequence[Part], shapes: Sequence[NamedSolid], name: str) -> TDocStd_Document:
    """Give the solids as products of their names, their faces coloured, and those with a frame as
    components of one assembly, each in its place."""
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    products, colours = (
        tool(document.Main()) for tool in (XCAFDoc_DocumentTool.ShapeTool_s, XCAFDoc_DocumentTool.ColorTool_s)
    )
    placed = []
    for part, (solid, faces) in zip(parts, shapes, strict=True):
        product = products.AddShape(solid, False)
        _called(product, part.name)
        for own, face in faces:
            colour = Quantity_Color(*COLOURS.get(own.rstrip(" 0123456789"), GREY), Quantity_TOC_sRGB)
            colours.SetColor(products.AddSubShape(product, face), colour, XCAFDoc_ColorSurf)
        if part.frame is not None:
            placed.append((part.name, product, _location(part.frame)))
    if placed:
        assembly = products.NewShape()
        _called(assembly, name)
        for own, product, place in placed:
            _called(products.AddComponent(assembly, product, place), own)
        products.UpdateAssemblies()
    return document


def _called(label: Any, name: str) -> None:
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))


def _location(frame: Frame) -> TopLoc_Location:
    """Give the place of a member's own frame in the kernel's terms."""
    rotation, origin = frame
    place = gp_Trsf()
    place.SetValues(*np.column_stack((rotation, origin)).ravel().tolist())
    return TopLoc_Location(place)


@contextmanager
def quiet_kernel() -> Iterator[None]:
    """Keep the kernel from reporting its progress on standard output."""
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    messenger.ChangePrinters().Clear()
    try:
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)


def _sign(model: Any, name: str) -> None:
    """Say what is in the file and what wrote it."""
    header = APIHeaderSection_MakeHeader(model)
    header.SetName(_text(name))
    header.SetOriginatingSystem(_text("beveloid-geom"))
    header.SetAuthorValue(1, _text(""))
    header.SetOrganizationValue(1, _text(""))


def _text(text: str) -> TCollection_HAsciiString:
    return TCollection_HAsciiString(text)
