"""Objectives and constraints of the optimisation of parabola coefficients or amounts of modification.

The shift is that of the position at mid-roll, perpendicular to the path as designed: a displacement along the
path is not a shift. (z, l1) are used as plane coordinates of the flank."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...arrays import FloatArray, flank_sign
from ...contact.path import path_of_contact
from ...design.arguments import require_numbers, require_single
from ...design.model import Design, Errors, MeshErrors
from ...pair.misalignment import mounted
from ..edge_contact import leads_of, swing_of_all
from ..mountings import swing_of


@dataclass(frozen=True)
class Aim:
    """Objective and constraints of an optimisation of parabola coefficients or amounts of modification.

    Attributes
    ----------
    errors : Errors or MeshErrors
        Assembly errors, mm and rad; each is applied alone and in both directions.
    contact_ratio : float
        Smallest contact ratio of the mounting without these errors.
    off_centre, shift : float
        Largest distance of the position at mid-roll from mid-face without these errors, and largest shift
        under them, mm.
    peak_to_peak : float
        Largest transmission error of the path without these errors, rad.
    pinion_parabola, gear_parabola : tuple of float
        Bounds of the coefficients, 1/mm.
    edges : bool
        Whether edge contact is allowed in a part of the mesh cycle, with or without errors.
    least : {'shift', 'transmission_error'}
        Objective: the shift of the path, or the transmission error of all teeth.
    """

    errors: Errors | MeshErrors
    contact_ratio: float = 1.6
    off_centre: float = 1.0
    peak_to_peak: float = np.inf
    pinion_parabola: tuple[float, float] = (-0.002, 0.002)
    gear_parabola: tuple[float, float] = (-0.002, 0.002)
    edges: bool = True
    shift: float = np.inf
    least: Literal["shift", "transmission_error"] = "shift"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the errors."""
        return tuple(vars(self.errors))

    def mountings(self) -> FloatArray:
        """Return errors (n, names), mm and rad: no error, then each error alone in both directions."""
        sizes = np.array(list(vars(self.errors).values()))
        single = np.diag(sizes)[sizes != 0.0]
        both = np.stack((single, -single), axis=1).reshape(-1, sizes.size)
        return np.concatenate((np.zeros((1, sizes.size)), both))

    def mounted(self, design: Design) -> Design:
        """Return a single design in all mountings of the aim, batch axis (n)."""
        return mounted(design, self.mountings(), self.names)


@dataclass(frozen=True, eq=False)
class Objectives:
    """Objectives and constrained quantities in the shape of the coefficients; NaN without a path, except for
    `contact_ratio`, which is 0 if the flanks have no path.

    `shift`, mm: the squared shifts under +error and -error are averaged and added over the errors; `shift` is
    the root of this sum. `centre`, mm: z
    at mid-roll on the pinion. `peak_to_peak`, rad: transmission error over the path. `leads` (2 n, ...), rad:
    leads of other tooth pairs at the ends of the paths in the n mountings (`edge_contact`); empty if the aim
    allows edge contact. `goals` (k, ...): the objectives, mm or rad; the largest one is minimised."""

    shift: FloatArray
    contact_ratio: FloatArray
    centre: FloatArray
    peak_to_peak: FloatArray
    leads: FloatArray
    goals: FloatArray

    def without_leads(self, count: int) -> Objectives:
        """Return these results without the constraints on leads for the first `count` designs of a batch (n).

        Leads of conjugate flanks are 0, although no edge touches: only the mesh cycle can show this."""
        first = np.arange(self.shift.size) < count
        return replace(self, leads=np.where(first, np.inf, self.leads))

    def margins(self, aim: Aim) -> FloatArray:
        """Return the margins of all constraints (constraints, ...), relative to their bounds; negative if
        violated."""
        ratio = self.contact_ratio / aim.contact_ratio - 1.0
        off, swing = self.centre / aim.off_centre, self.peak_to_peak / aim.peak_to_peak
        moved = 1.0 - self.shift / aim.shift
        # Smallest lead of another tooth pair at the end of a path, and the lead that counts as a margin of 1.
        least_lead_rad, lead_scale_rad = 1e-9, 1e-4
        return np.array(
            [ratio, 1.0 - off, 1.0 + off, 1.0 - swing, moved, *(self.leads - least_lead_rad) / lead_scale_rad]
        )


def objectives_of(design: Design, flank: str, aim: Aim, pinion: FloatArray, gear: FloatArray) -> Objectives:
    """Return the objectives for parabola coefficients `pinion` and `gear`, 1/mm, which broadcast."""
    pinion, gear = np.broadcast_arrays(np.asarray(pinion, dtype=float), np.asarray(gear, dtype=float))
    return objectives_of_designs(design.with_parabola(pinion, gear), flank, aim)


def objectives_of_designs(designs: Design, flank: str, aim: Aim) -> Objectives:
    """Return the objectives of a design or of a batch of designs."""
    path_points = 17
    errors, shape = aim.mountings(), designs.batch_shape
    batch = mounted(designs, errors.reshape(-1, *[1] * len(shape), errors.shape[1]), aim.names)
    path = path_of_contact(batch, flank, path_points)
    middle = path_points // 2
    place = np.stack((path.pinion_z, path.l1), axis=-1)
    along = place[0, ..., middle + 1, :] - place[0, ..., middle - 1, :]
    with np.errstate(invalid="ignore"):  # a path may be a single point, which has no direction
        along = along / np.hypot(along[..., 0], along[..., 1])[..., None]
    moved = place[1:, ..., middle, :] - place[0, ..., middle, :]
    across = moved[..., 0] * along[..., 1] - moved[..., 1] * along[..., 0]
    shift = np.sqrt(0.5 * (across**2).sum(axis=0))
    return Objectives(
        shift=shift,
        contact_ratio=path.ends.contact_ratio[0],
        centre=place[0, ..., middle, 0],
        peak_to_peak=swing_of(path.transmission_error[0]),
        leads=np.empty((0, *shape)) if aim.edges else leads_of(path).reshape(-1, *shape),
        goals=shift[None] if aim.least == "shift" else swing_of_all(path),
    )


def check_aim(design: Design, aim: Aim, flank: str) -> None:
    """Raise ValueError for a batch, an unknown flank, and values of the aim outside their limits. The bounds
    of the coefficients are not checked here."""
    flank_sign(flank)
    require_single(design)
    errors = list(vars(aim.errors).values())
    if not any(errors):
        raise ValueError(f"errors of the aim must be finite and not all 0, got {errors}")
    if aim.least not in ("shift", "transmission_error"):
        raise ValueError(f"least of the aim must be shift or transmission_error, got {aim.least!r}")
    if aim.least == "transmission_error" and aim.edges:
        raise ValueError("least='transmission_error' requires teeth without edge contact: set edges=False")
    for name in ("contact_ratio", "off_centre", "peak_to_peak", "shift"):
        value = getattr(aim, name)
        require_numbers(**{f"{name} of the aim": value})
        if not value > 0.0 or (value == np.inf and name not in ("peak_to_peak", "shift")):
            raise ValueError(f"{name} of the aim must be positive and finite, got {value}")
