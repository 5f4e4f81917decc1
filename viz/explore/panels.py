"""Curves and areas of the flattened flanks and of the motion graph, as plain numbers for the page.

Positions on a flank are in mm as in `components.flattened_flank`, rounded to 1 um. The motion graph is in
pitches and arcsec.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from contourpy import FillType, contour_generator
from numpy.typing import ArrayLike

from beveloid_geom import ContactPath, ContactPattern, Design, MemberPattern, Status
from beveloid_geom.report.columns import ARCSEC
from beveloid_geom.report.operation import OperationReport
from beveloid_geom.status import FirstStatus

from ..components.flattened_flank import BAND_FRACTIONS, ROLLS_PER_POINT, FlatFlank, flat_flank
from ..components.motion_graph import REACH_PITCHES, motion_graph
from ..components.paths_table import MEMBERS, points_on

LIFT_MODULES = 0.01
"""Height of the contact pattern above the tooth surface in the 3D view, in modules, so that the triangles of
the tooth do not hide it."""


def rows(values: ArrayLike, decimals: int = 3) -> list[Any]:
    """Return rounded numbers as lists, None for NaN."""
    array = np.asarray(values, dtype=float).round(decimals) + 0.0
    listed = array.astype(object)
    listed[~np.isfinite(array)] = None
    return list(listed.tolist())


def flank_panels(report: OperationReport, path: ContactPath) -> list[dict[str, Any] | None]:
    """Return outline, path and first contacts on pinion and gear; None for a flank without a projection.

    The path has None in place of positions that are not on both flanks. First contacts are those of all teeth
    over a mesh cycle, (n, 3): position, and 1 for edge contact.
    """
    first = report.first
    edge = (first.limit[:, 0] >= 0) & (not report.along_lines)
    panels: list[dict[str, Any] | None] = []
    for number, member in enumerate(report.design.members):
        flat = flat_flank(member, report.flank)
        if flat is None:
            panels.append(None)
            continue
        solved = path.status == Status.SOLVED
        points = np.where(solved[:, None], flat.place(points_on(path, number)), np.nan)
        l, z = ((first.l1, first.z1), (first.l2, first.z2))[number]
        shown = (first.status == FirstStatus.SOLVED) & ~first.on_fillet[:, number]
        shown &= np.arange(l.size) % ROLLS_PER_POINT == 0
        contacts = np.column_stack((flat.at(l[shown], z[shown]), edge[shown]))
        back, front = flat.view.ends
        panel = {"member": MEMBERS[number], "outline": rows(flat.outline), "back": back, "front": front}
        panels.append(panel | {"path": rows(points), "contacts": rows(contacts)})
    return panels


def graph_panel(report: OperationReport) -> dict[str, Any]:
    """Return the motion graph: curves of one tooth pair alone and in operation, with masks of edge contact.

    Pitches from the start of the cycle, transmission errors in arcsec from their mean.
    """
    graph = motion_graph(report, None)
    first, cycle, mean = report.first, report.cycle, graph.mean
    edge = (first.limit[:, 0] >= 0) & (not report.along_lines)
    changes = cycle.changes[cycle.hand_over]
    at = (changes - float(cycle.start)) / cycle.pitch
    there = cycle.at(changes).transmission_error - mean
    return {
        "reach": REACH_PITCHES,
        "pitches": rows(graph.pitches, 5),
        "alone": rows(ARCSEC * (graph.alone - mean), 4),
        "alone_edge": graph.edge.tolist(),
        "operation": rows(ARCSEC * (first.transmission_error - mean), 4),
        "operation_edge": edge.tolist(),
        "changes": rows(np.column_stack((at, ARCSEC * there)), 4),
        "limits": rows([ARCSEC * limit for limit in graph.limits], 4),
        "um_per_arcsec": 1e3 * graph.pitch_radius / ARCSEC,
    }


def pattern_panels(design: Design, flank: str, pattern: ContactPattern) -> list[dict[str, Any]]:
    """Return the pattern on pinion and gear: areas on the flattened flank, and a patch for the 3D view.

    `bands` are areas of growing separation, each a list of closed polygons; the last is the pattern. The
    patch has points (mm, in the frame of the member), the level (square root of the separation less that of
    the limit, both in mm; negative inside the pattern), and the tolerance of its triangles in mm. Seen from
    outside the tooth, the direction of increasing columns is counter-clockwise from that of increasing rows.
    """
    panels = []
    for member, side in zip(design.members, (pattern.pinion, pattern.gear), strict=True):
        flat, module = flat_flank(member, flank), float(member.tool.normal_module)
        bands = [] if flat is None else _bands(flat, side, pattern.separation)
        panels.append({"bands": bands, "patch": _patch(side, pattern.separation, module)})
    return panels


def _bands(flat: FlatFlank, side: MemberPattern, separation: float) -> list[list[Any]]:
    """Return the polygons within fractions of the separation. Between points, the square root of the
    separation is interpolated, which is nearly linear next to the path. The last polygons are the border of
    the pattern, which is more accurate than the grid at an edge of the mating flank."""
    x, y = np.moveaxis(flat.place(side.points), -1, 0)
    level = np.ma.masked_invalid(np.sqrt(np.maximum(side.least, 0.0)))
    areas: Any = contour_generator(x, y, level, fill_type=FillType.OuterOffset)
    bands = []
    for share in BAND_FRACTIONS[:-1]:
        points, offsets = areas.filled(-1.0, float(np.sqrt(share * separation)))
        rings = [
            rows(each[low:high], 2)
            for each, ends in zip(points, offsets, strict=True)
            for low, high in pairwise(ends)
        ]
        bands.append(rings)
    return [*bands, [rows(flat.place(polygon), 2) for polygon in side.border]]


def _patch(side: MemberPattern, separation: float, module: float) -> dict[str, Any]:
    """Return a coarser grid of points next to the flank, with the level."""
    # Largest number of points over depth and face of the pattern in the 3D view.
    patch = (13, 37)
    picked = [
        np.unique(np.linspace(0, size - 1, min(size, most)).round().astype(int))
        for size, most in zip(side.l.shape, patch, strict=True)
    ]
    points = side.points[np.ix_(*picked)]
    along, across = np.gradient(points, axis=1), np.gradient(points, axis=0)
    normal = np.cross(along, across)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    middle = points[len(points) // 2, points.shape[1] // 2]
    turn = np.cross((0.0, 0.0, 1.0), middle) @ normal[len(points) // 2, points.shape[1] // 2]
    # Out of the tooth: the tooth is centred on the x axis, so that a flank with y < 0 faces -y.
    outwards = 1.0 if (turn > 0.0) == (middle[1] > 0.0) else -1.0
    edge = float(np.sqrt(separation))
    level = np.sqrt(np.maximum(side.least[np.ix_(*picked)], 0.0)) - edge
    points = points + LIFT_MODULES * module * outwards * normal
    if outwards > 0.0:  # then rows, columns and outward normal are right-handed
        points, level = points[:, ::-1], level[:, ::-1]
    return {
        "size": list(points.shape[:2]),
        "points": rows(points.ravel()),
        "levels": rows(np.nan_to_num(level, nan=edge).ravel(), 5),
        "tolerance": 0.5 * LIFT_MODULES * module,
    }
