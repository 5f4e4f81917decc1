"""How the pair moves over one pitch of the pinion, and where its teeth touch meanwhile.

The motion is that of the first contact of all teeth, edges included: the gear stands where a rigid
gear would be stopped. So no driving teeth overlap, the transmission error is part of what is seen, and
with the pinion's pitch everything repeats. The paths of contact, where flanks are tangent, go with it.
The other flanks are left out: where edges push the gear ahead by more than the backlash, they overlap.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beveloid_geom import Design, first_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import MARKING_SEPARATION
from beveloid_geom.contact.placing import frames_at
from beveloid_geom.findings.path import first_contact_fault, reason_of
from beveloid_geom.gear.flank import turned
from beveloid_geom.gear.tooth_side import cut_at, surface_of
from beveloid_geom.operation.first_contact import FirstContact, mesh_of
from beveloid_geom.report.operation import OperationReport, operation_report

from ..parts import solved
from ..parts.solved import SolvedPath

FILM = MARKING_SEPARATION
"""mm: thickness of marking compound; teeth nearer than this are shown as about to touch."""
TOUCHING = 1e-6
"""mm: teeth nearer than this count as touching."""
CURVE = 240
"""Least number of steps at which the transmission error is drawn."""
HARMONICS = 1  # the least there may be: the film shows none


class NoFilmError(ValueError):
    """The pair has no motion to show; the message says why."""


@dataclass(frozen=True, eq=False)
class Motion:
    """The pair at pinion rolls (n,), in shares of a pitch from where the pinion's flank passes the pitch
    point.

    `frames`: rotations (n, 3, 3) and origins (n, 3) of pinion and gear. For the tooth pairs `pairs`
    (k,), pinion tooth p with gear tooth -p: `gap` (k, n), mm along the normal, by which the pair is off
    the first to touch, NaN out of reach; `point` (k, n, 3) in S_f where it would touch first, and the
    same on tooth 0 in the own frames of pinion and gear, `own` (2, k, n, 3), mm. `error` (n,), rad, is
    the transmission error less its mean; `carriers` name what carries."""

    design: Design
    flank: str
    share: FloatArray
    frames: tuple[tuple[FloatArray, FloatArray], ...]
    pairs: NDArray[np.int_]
    gap: FloatArray
    point: FloatArray
    own: FloatArray
    error: FloatArray
    carriers: list[str]

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Which pairs (k, n) touch."""
        return np.asarray(self.gap <= TOUCHING)

    @property
    def near(self) -> NDArray[np.bool_]:
        """Which pairs (k, n) touch or are within the thickness of marking compound of it."""
        return np.asarray(self.gap <= FILM)


@dataclass(frozen=True, eq=False)
class Film:
    """What a film shows: the path of contact, one mesh cycle, and the motion at every frame of it."""

    path: SolvedPath
    cycle: OperationReport
    motion: Motion


def film_of(design: Design, flank: str, frames: int, name: str = "") -> Film:
    """Find the motion of a single design, called `name`, over one pitch in equal steps. Raises NoFilmError
    where the flanks share no contact, or where it is not known what touches first."""
    path = solved.solve(design, flank)
    reason = reason_of(path.path) or first_contact_fault(design)
    if reason:
        raise NoFilmError(reason)
    finer = -(-CURVE // frames)
    cycle = operation_report(name, design, flank, finer * frames + 1, HARMONICS, FILM)
    if cycle.reason:
        raise NoFilmError(cycle.reason)
    return Film(path, cycle, motion_at(cycle, np.arange(frames) / frames))


def motion_at(cycle: OperationReport, share: FloatArray) -> Motion:
    """Find the pair at shares (n,) of the pitch; the cycle must be known."""
    design, flank = cycle.design, cycle.flank
    roll = float(cycle.cycle.start) + cycle.cycle.pitch * share
    first = cycle.cycle.at(roll)
    mesh, _ = mesh_of(design, flank, roll)
    pairs = np.unique(mesh.nearest[:, None] + mesh.near)
    alone = [first_contact(design, flank, roll, (pair,)) for pair in pairs]
    behind = np.stack([one.transmission_error for one in alone]) - first.transmission_error
    return Motion(
        design,
        flank,
        share,
        frames_at(design, roll, first.gear_roll),
        pairs,
        mesh.own.sigma * mesh.lever * behind,
        np.stack([one.point for one in alone]),
        np.stack([_own_points(design, flank, one) for one in alone], axis=1),
        first.transmission_error - float(cycle.cycle.mean),
        replace(cycle, first=first).carriers,
    )


def _own_points(design: Design, flank: str, first: FirstContact) -> FloatArray:
    """Give the contacts (2, n, 3), on flanks or fillets, on tooth 0 of pinion and gear, own frames, mm."""
    places = (first.l1, first.z1), (first.l2, first.z2)
    points = []
    for member, (s, z) in zip(design.members, places, strict=True):
        with np.errstate(invalid="ignore"):
            cut = cut_at(surface_of(member, flank), s, z)
            points.append(turned(cut.phi, cut.x, cut.y, z))
    return np.stack(points)
