"""Positions and contacts of a gear pair over one pitch of the pinion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beveloid_geom import Design, first_contact, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import MARKING_SEPARATION_MM
from beveloid_geom.contact.mesh_position import frames_at
from beveloid_geom.contact.parallel.lines import contact_lines, is_line_contact
from beveloid_geom.findings.path import first_contact_fault, reason_of
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.operation.engagement import engagement_of
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.report.operation import OperationReport, operation_report

from ..components import paths_table
from ..components.paths_table import SolvedPath
from ..components.posed import on_tooth


class NoFilmError(ValueError):
    """Raised if the motion of a pair is not available. The argument is the reason: a `NotComputed` (a
    subclass of str) if the calculation failed."""


@dataclass(frozen=True, eq=False)
class Film:
    """Motion of a pair over one pitch of the pinion in n equal steps.

    Attributes
    ----------
    path : SolvedPath
        Path of contact.
    report : OperationReport
        Mesh cycle, with the first contact of all teeth at the n steps.
    frames : tuple
        Rotation (n, 3, 3) and origin (n, 3), mm, of pinion and gear in S_f.
    pairs : ndarray of int, shape (k,)
        Tooth pairs: pinion tooth p and gear tooth -p.
    gap : ndarray, shape (k, n)
        Gap of each tooth pair along the normal, mm. The gap of the pair in contact is 0. NaN if the teeth
        cannot touch.
    point : ndarray, shape (k, n, 3)
        Point in S_f, mm, where each tooth pair would touch first.
    lines : tuple of ndarray, shape (k, n, 2, 3)
        Ends of the line of contact of each tooth pair on tooth 0 of pinion and gear, in their frames, mm; NaN
        without one.
    """

    path: SolvedPath
    report: OperationReport
    frames: tuple[tuple[FloatArray, FloatArray], ...]
    pairs: NDArray[np.int_]
    gap: FloatArray
    point: FloatArray
    lines: tuple[FloatArray, FloatArray]

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Mask (k, n) of the tooth pairs in contact."""
        # Largest gap at which two teeth are counted as in contact.
        contact_gap_mm = 1e-6
        return np.asarray(self.gap <= contact_gap_mm)

    @property
    def near(self) -> NDArray[np.bool_]:
        """Mask (k, n) of the tooth pairs with a gap below the thickness of marking compound."""
        return np.asarray(self.gap <= MARKING_SEPARATION_MM)

    def line_in_mesh(self, step: int) -> FloatArray:
        """Return the lines of contact (k, 2, 3) at a step in S_f, mm."""
        member, (rotation, origin) = self.path.design.pinion, self.frames[0]
        turned = zip(self.lines[0][:, step], self.pairs.tolist(), strict=True)
        return to_fixed(
            (rotation[step], origin[step]), np.stack([on_tooth(line, member, pair) for line, pair in turned])
        )

    def on_tooth_0(self, number: int) -> FloatArray:
        """Return the contacts (k, n, 3) turned to tooth 0 of pinion (0) or gear (1), in its frame, mm."""
        rotation, origin = self.frames[number]
        member = self.path.design.members[number]
        on_teeth = np.einsum("kni,nij->knj", self.point - origin, rotation)
        teeth = self.pairs * (-1 if number else 1)  # gear tooth -p meets pinion tooth p
        return np.stack(
            [on_tooth(points, member, -tooth) for points, tooth in zip(on_teeth, teeth, strict=True)]
        )


def film_of(design: Design, flank: str, steps: int, name: str = "") -> Film:
    """Compute the motion of a single design over one pitch of the pinion.

    The gear is held by the first contact of all teeth, edges included: rigid teeth without load. The motion
    therefore contains the transmission error, and repeats after one pitch.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
        Flanks in contact.
    steps : int
        Number of positions.
    name : str
        Name of the design for the title.

    Raises
    ------
    NoFilmError
        If the flanks have no contact, or if the first contact could not be computed.
    """
    path = paths_table.solved_case(design, flank)
    if reason := reason_of(path.path) or first_contact_fault(design):
        raise NoFilmError(reason)
    report = operation_report(name, design, flank, steps + 1, 1, MARKING_SEPARATION_MM)
    if report.reason:
        raise NoFilmError(report.reason)
    roll = float(report.cycle.start) + report.cycle.pitch * np.arange(steps) / steps
    first = report.cycle.at(roll)
    mesh, _ = engagement_of(design, flank, roll)
    pairs = np.unique(mesh.nearest[:, None] + mesh.near)
    alone = [first_contact(design, flank, roll, (pair,)) for pair in pairs]
    behind = first.transmission_error - np.stack([each.transmission_error for each in alone])
    frames = frames_at(design, roll, first.gear_roll)
    point = np.stack([each.point for each in alone])
    lines = _lines_of_contact(path, roll + report.cycle.pitch * pairs[:, None])
    return Film(path, replace(report, first=first), frames, pairs, mesh.lever * behind, point, lines)


def _lines_of_contact(solved: SolvedPath, rolls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the lines of contact (k, n, 2, 3) of tooth 0 of pinion and gear at rolls (k, n), in their
    frames, mm; NaN for point contact and outside the path."""
    path, design = solved.path, solved.design
    lines = np.full((2, *rolls.shape, 2, 3), np.nan)
    if not (solved.has_path and is_line_contact(design, path.flank)):
        return lines[0], lines[1]
    order = np.argsort(path.pinion_roll)
    l1 = np.interp(rolls, path.pinion_roll[order], path.l1[order], np.nan, np.nan)
    inside = np.isfinite(l1)
    on_path = contact_lines(path_of_contact(design, path.flank, l1=l1[inside]))
    ends = (on_path.l1, on_path.pinion_z), (on_path.l2, on_path.gear_z)
    for number, (l, z) in enumerate(ends):
        lines[number][inside] = flank_point(design.members[number], path.flank, l, z=z)
    return lines[0], lines[1]
