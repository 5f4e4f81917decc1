"""Engagement of a pair at pinion rolls: surfaces, axes, and the tooth pairs that can touch."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..arrays import FloatArray, Integers, Mask
from ..contact.flank_pair import is_modified, pairing_of
from ..contact.parallel.lines import touches_along_lines
from ..contact.path import path_of_contact
from ..contact.path_polynomial import PHASE, exact_rows
from ..contact.surfaces.problems import with_line_crowning
from ..design.model import PARALLEL_AXES_SINE, Design, Pair
from ..gear.tooth_side import ToothSurface, angle_of, cut_at, surface_of
from ..pair.mounting import limit_phase, mounting_of
from ..support.frozen_arrays import cached
from .angular_clearance import AxisPositions, axes_of
from .search.search_task import Task

Place: TypeAlias = FloatArray | tuple[FloatArray, ...]
"""Profile coordinates and distances from mid-face (2, ...), mm."""


@dataclass(frozen=True, eq=False)
class Engagement:
    """Tooth surfaces and axes of a pair at pinion rolls (n,), and the tooth pairs that can touch.

    Attributes
    ----------
    pinion, gear : ToothSurface
        Tooth surfaces of pinion and gear.
    axes : AxisPositions
        (n,), or (1,) if they are the same at all positions.
    roll, phase : ndarray, shape (n,)
        Pinion roll, and conjugate phase of the gear (gear roll plus N1/N2 pinion roll), rad.
    nearest : ndarray of int, shape (n,)
        Tooth pair that is nearest to the pitch point.
    pitch : tuple of float
        Angular pitches of pinion and gear, rad.
    lever : float
        Clearance along the normal per rad of gear roll, m_n N2 cos(alpha) / 2, mm.
    module : float
        Normal module, mm.
    reach : int
        Number of tooth pairs on either side that can touch.
    period : float
        Rotation of the gear after which a pinion tooth forms a tooth pair again, rad: as many gear pitches as
        the smaller number of teeth. If the pinion has fewer teeth, this pair has another gear tooth.
        Otherwise it has the same gear tooth, after a full turn.
    again : int
        Decrease of the number of a tooth pair when the gear is moved on by one `period`: the number of pinion
        teeth if the pinion has fewer teeth than the gear, otherwise 0, because a period is then a full turn.
    defined : ndarray of bool, shape (n,)
        Whether all inputs but the phase are finite.
    span : float
        For segments: range of pinion roll that they cover from each position on, in pitches of the pinion.
    lines : ndarray, shape (4, 2, n), optional
        For unmodified flanks that touch along lines. Rows: conjugate phase (rad), pinion roll (rad), s1 and
        z1 (mm). Columns: first and last contact of tooth pair 0 on the path of contact. s1 and z1 are linear
        in the pinion roll between them. NaN for point contact; None if no position has lines.
    line_contact : bool
        Whether modified flanks touch along lines. The searched pinion then has an additional helix crowning
        of 1e-8 modules (`contact.surfaces.problems.with_line_crowning`). The position of a contact along its
        line is uncertain, because this crowning changes the clearance by little more than rounding.
    """

    pinion: ToothSurface
    gear: ToothSurface
    axes: AxisPositions
    roll: FloatArray
    phase: FloatArray
    nearest: Integers
    pitch: tuple[float, float]
    lever: float
    module: float
    reach: int
    period: float
    again: int
    defined: Mask
    span: float = 1.0
    lines: FloatArray | None = None
    line_contact: bool = False

    @property
    def turns(self) -> float:
        """Return the turns of a pinion tooth round its axis along the face."""
        return abs(float(self.pinion.trace[1])) * self.pinion.half_width / (np.pi * self.pinion.pitch_radius)

    @property
    def measured(self) -> bool:
        """Return whether a flank has measured deviations. It may have waves, with several minima of the
        clearance, and its third derivatives jump between the measured points."""
        modifications = (self.pinion.modification, self.gear.modification)
        return any(one is not None and one.measured for one in modifications)

    @property
    def near(self) -> Integers:
        """Return the tooth pairs that can touch, relative to the nearest; each pinion tooth once."""
        teeth = round(2.0 * np.pi / self.pitch[0])
        every = np.arange(-self.reach, self.reach + 1)
        return every if every.size <= teeth else np.arange(teeth) - teeth // 2

    def task(self, position: Integers, pair: Integers, fillet: Mask | None = None) -> Task:
        """Return the task of tooth pairs `pair` (n,) at the positions with the numbers `position` (n,).

        `fillet` (2, n), if known: whether the contact is sought on the fillet of an undercut tooth."""
        roll = self.roll[position] + pair * self.pitch[0]
        start = self.phase[position] - self.pitch[1] / self.pitch[0] * roll
        line = None if self.lines is None else self._on_lines(position, roll)
        axes = self.axes.at(position)
        return Task(self.pinion, self.gear, self.lever, axes, roll, start, self.period, line, fillet)

    def _on_lines(self, position: Integers, roll: FloatArray) -> FloatArray:
        """Return `Task.line` of tooth pair 0 at pinion rolls (n,), rad."""
        assert self.lines is not None
        (phase, _), ends, s, z = self.lines[:, :, position]
        share = (roll - ends[0]) / (ends[1] - ends[0])
        ahead = self.gear.sigma * self.lever * (phase - self.phase[position])
        # The path of a line contact ends on limits. At the joint, rounding must not place it on the fillet.
        joint = np.where((share < 0.0) | (share > 1.0), -np.inf, self.pinion.joint)
        s = np.maximum(s[0] + share * (s[1] - s[0]), joint)
        return np.array((ahead, s, z[0] + share * (z[1] - z[0]), share))

    def on_fillets(self, place: Place, meeting: Place) -> Mask:
        """Return whether places (s1, z1) and touched points (s2, z2), mm, are on the fillets: (2, ...)."""
        return np.stack((self.pinion.on_fillet(*place), self.gear.on_fillet(*meeting)))

    @property
    def has_reliefs(self) -> bool:
        """Whether a flank has a relief."""
        modifications = self.pinion.modification, self.gear.modification
        return any(one is not None and len(one.reliefs) for one in modifications)

    def past_reliefs(self, place: Place, meeting: Place) -> FloatArray:
        """Return the distance (mm) of places (s1, z1) and touched points (s2, z2), mm, from the beginning of
        all reliefs of pinion and gear, positive on the relief: (reliefs, ...)."""
        return np.concatenate((self.pinion.past_reliefs(*place), self.gear.past_reliefs(*meeting)))

    def at(self, position: Integers, roll: FloatArray) -> Engagement:
        """Return the engagement at other rolls (n,), rad, of the positions with these numbers (n,)."""
        turned = np.rint((roll - self.roll[position]) / self.pitch[0]).astype(int)
        return replace(
            self,
            axes=self.axes.at(position),
            roll=roll,
            phase=self.phase[position],
            nearest=self.nearest[position] - turned,
            defined=self.defined[position],
            lines=None if self.lines is None else self.lines[:, :, position],
        )


def conjugate_phase(design: Design, flank: str) -> FloatArray:
    """Compute the gear roll plus N1/N2 pinion roll of the unmodified pair without errors.

    It is the same for all contacts of unmodified flanks, and the zero of the transmission error. If the
    flanks have no contact near the face, it is the phase of parallel axes at the distance that the axes have
    at the mesh, provided that the flanks are conjugate on parallel axes. Otherwise it is `limit_phase`.

    Rolls are measured from the common perpendicular of the axes with errors. On parallel axes, errors can
    turn it (`turned_by_errors`).

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}

    Returns
    -------
    ndarray
        rad, of the batch shape; NaN for a design without mounting distances.
    """
    ratio = np.asarray(design.pinion.teeth / design.gear.teeth)
    return _plain_phase(design.bare(), flank) + (1.0 + ratio) * turned_by_errors(design)


def _plain_phase(plain: Design, flank: str) -> FloatArray:
    """Return the conjugate phase of a pair without modifications and errors."""
    find = _conjugate_phase if plain.batch_shape else _cached_phase
    phase = find(plain, flank)
    if not np.isnan(phase).any():
        return phase
    axes = axes_of(plain)
    lost = np.isnan(phase) & np.isfinite(axes.position.sum(axis=0))
    if not lost.any():
        return phase
    pinion, gear = np.where(lost, axes.position, 0.0)
    # At the mesh, the gear's axis is `aside` from the common perpendicular. This adds `turn` to both rolls.
    aside = gear * axes.sin
    turn = np.arctan2(aside, axes.offset)
    parallel = Pair(np.hypot(aside, axes.offset), 0.0, pinion - gear, 0.0)
    ratio = np.asarray(plain.pinion.teeth / plain.gear.teeth)
    on_parallel = find(replace(plain, pair=parallel), flank) + (1.0 + ratio) * turn
    return np.where(lost, np.where(np.isnan(on_parallel), limit_phase(plain, flank), on_parallel), phase)


def _conjugate_phase(plain: Design, flank: str) -> FloatArray:
    pairing = pairing_of(plain, flank)
    with np.errstate(invalid="ignore", divide="ignore"):
        rows, _ = exact_rows(pairing, np.zeros((pairing.branch.shape[0], 1)))
    return rows[PHASE, :, 0].reshape(plain.batch_shape)


_cached_phase = cached(16)(_conjugate_phase)


def pitch_point_roll(design: Design, flank: str) -> FloatArray:
    """Compute the pinion roll at which the flank of tooth 0 passes the pitch point.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}

    Returns
    -------
    ndarray
        rad, of the batch shape. If the pitch point is far from the teeth, as on nearly parallel axes, the
        point of the pinion nearest to the gear is used instead.
    """
    mounting, surface, axes = mounting_of(design), surface_of(design.pinion, flank), axes_of(design)
    x, y = (mounting.pitch_point[..., k] for k in (0, 1))
    # On intersecting axes the pitch point is in the plane x = 0, except for rounding.
    far = ~((x > -1e-9 * surface.tip) & (np.abs(np.hypot(x, y) - surface.tip) < 0.5 * surface.tip))
    turn = np.where(far, direction_at_mesh(axes), np.arctan2(y, x) + turned_by_errors(design))
    z, apex = _pitch_height(design, surface), float(design.pinion.tool.parabola_apex)
    # On the reference line of the tool; s is measured from the apex of the parabola.
    return np.asarray(turn - angle_of(cut_at(surface, np.zeros_like(z) - apex, z)))


def direction_at_mesh(axes: AxisPositions) -> FloatArray:
    """Return the angle (rad) about the pinion axis of the point of the gear's axis that is nearest to the
    pinion's mid-face, from the common perpendicular."""
    across = np.nan_to_num(axes.position[0] * axes.sin * axes.cos)
    return np.asarray(np.arctan2(across, np.nan_to_num(axes.offset)))


def turned_by_errors(design: Design) -> FloatArray:
    """Return the angle (rad) about the pinion axis from the common perpendicular with errors to that without
    errors, for parallel axes; 0 for other axes.

    A small tilt turns the perpendicular, because the axes then cross far away from the gears. Rolls are
    measured from the perpendicular with errors: this angle is added to those of the pair without errors."""
    parallel = np.abs(np.sin(design.pair.shaft_angle)) <= PARALLEL_AXES_SINE
    return np.where(parallel, direction_at_mesh(axes_of(design)), 0.0) if parallel.any() else np.zeros(())


def _pitch_height(design: Design, surface: ToothSurface) -> FloatArray:
    """Return z (mm) of the pitch point on the pinion, limited to its face."""
    mounting = mounting_of(design)
    z = np.nan_to_num(mounting.pitch_distance[0] - mounting.distance[0])
    return np.asarray(np.clip(z, -surface.half_width, surface.half_width))


def spread(design: Design, flank: str) -> float:
    """Compute how far tooth contacts can be from the pitch point, owing to the overlap of helical teeth.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}

    Returns
    -------
    float
        Pitches of the pinion by which the tooth trace on the pitch cylinder departs from the pitch point, the
        maximum over a batch.
    """
    surface = surface_of(design.pinion, flank)
    length = surface.half_width + np.abs(_pitch_height(design, surface)).max()
    turn = length * np.abs(surface.trace[1]) / surface.pitch_radius
    return float(turn * float(design.pinion.teeth) / (2.0 * np.pi))


def engagement_of(
    design: Design, flank: str, roll: FloatArray, middle: FloatArray | None = None
) -> tuple[Engagement, FloatArray]:
    """Return the engagement of a design at pinion rolls.

    Parameters
    ----------
    design : Design
        The fields of the members must not be arrays; pair and errors may be arrays.
    flank : {'right', 'left'}
    roll : ndarray, shape (..., positions)
        Pinion rolls, rad.
    middle : ndarray, optional
        `pitch_point_roll` of the design, if known.

    Returns
    -------
    engagement : Engagement
        All positions on one axis.
    phase : ndarray, shape (n,)
        Conjugate phase by position, rad; NaN where there is none.
    """
    searched, along_lines = with_line_crowning(design, flank)
    pinion, gear = (surface_of(member, flank) for member in searched.members)
    phase = np.broadcast_to(conjugate_phase(design, flank)[..., None], roll.shape).reshape(-1)
    axes = axes_of(design)
    shape = roll.shape if design.batch_shape else (1,)
    by_position = [
        np.broadcast_to(value[..., None], shape).reshape(-1)
        for value in (axes.offset, axes.sin, axes.cos, *axes.position)
    ]
    tool, teeth = design.gear.tool, [int(member.teeth) for member in design.members]
    lever = 0.5 * float(tool.normal_module) * teeth[1] * np.cos(float(tool.normal_pressure_angle))
    middle = pitch_point_roll(design, flank) if middle is None else middle
    middle = np.broadcast_to(middle[..., None], roll.shape).reshape(-1)
    pitch = (2.0 * np.pi / teeth[0], 2.0 * np.pi / teeth[1])
    engagement = Engagement(
        pinion=pinion,
        gear=gear,
        axes=AxisPositions(by_position[0], by_position[1], by_position[2], np.stack(by_position[3:])),
        roll=roll.reshape(-1),
        phase=np.nan_to_num(phase),
        nearest=np.rint((middle - roll.reshape(-1)) / pitch[0]).astype(int),
        pitch=pitch,
        lever=lever,
        module=float(tool.normal_module),
        reach=2 + int(np.ceil(spread(design, flank))),
        period=min(teeth) * pitch[1],
        again=teeth[0] if teeth[0] < teeth[1] else 0,
        defined=np.broadcast_to(np.isfinite(sum(by_position) + pinion.highest + gear.highest), roll.size),
        lines=_lines_of(design, flank, roll.shape),
        line_contact=along_lines,
    )
    return engagement, phase


def _lines_of(design: Design, flank: str, shape: tuple[int, ...]) -> FloatArray | None:
    """Return `Engagement.lines` for positions of this shape, batch axes first."""
    if design.has_parabola or is_modified(design, flank):
        return None
    along = touches_along_lines(design, flank)
    if not along.any():
        return None
    path = path_of_contact(design, flank, 2)
    if not path.l1.shape[-1]:  # lines exist on the extended flanks only
        return None
    ratio = np.asarray(design.pinion.teeth / design.gear.teeth)[..., None]
    phase = path.gear_roll + ratio * path.pinion_roll
    rows = np.stack((phase, path.pinion_roll, path.l1, path.pinion_z))
    rows = np.where(along[..., None], rows, np.nan)
    per_position = np.broadcast_to(rows[..., None, :], (*rows.shape[:-1], shape[-1], 2))
    return np.moveaxis(per_position.reshape(len(rows), -1, 2), -1, 1)
