"""Paths of contact and backlash of one design in many mountings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray, Integers, Mask
from ..contact.path import ContactPath, path_of_contact
from ..design.model import Design
from ..operation.backlash_by_tangency import TangentBacklash, jammed, tangent_backlash
from ..pair.misalignment import mounted
from ..status import Status
from ..support.array_repr import short_repr
from .sliding import least_along

PLACES = ("enter", "middle", "leave")
"""Columns of positions: where the path enters, its mid-roll, and where it leaves."""
PATH_POINTS = 17
"""Number of positions of a path, from which its extreme transmission errors are interpolated."""


@dataclass(frozen=True, eq=False)
class Mountings:
    """Paths of contact of n mountings; NaN where a mounting has no path.

    Attributes
    ----------
    errors : FloatArray
        (n, names), drawn errors in the order of `Tolerances.names`, mm and rad, without the errors of the
        design.
    status : Codes
        (n,), codes of `Status`.
    limit : Codes
        (n, 2), codes of `Limit` where the path enters and leaves; -1 without a path.
    pieces : Integers
        (n,), number of segments in which the path lies on the flanks.
    contact_ratio : FloatArray
        (n,), Eq. 16; 0 without contact on the flanks.
    peak_to_peak : FloatArray
        (n,), rad: peak-to-peak transmission error of the path.
    pinion_z, pinion_r, gear_z, gear_r : FloatArray
        (n, 3), mm: position where the path enters, at mid-roll, and where it leaves.
    normal_backlash : FloatArray
        (n,), mm: smallest normal backlash over a mesh cycle, from the tangency of the flanks on both sides
        (`operation.backlash_by_tangency`). It is also computed if these flanks have no path.
    tangency : Codes
        (n,), codes of `Tangency`: whether `normal_backlash` is the backlash of the teeth, a lower bound, an
        estimate, or unknown.
    jammed : Mask
        (n,): the backlash is too small to assemble the pair.
    """

    __repr__ = short_repr

    errors: FloatArray
    status: Codes
    limit: Codes
    pieces: Integers
    contact_ratio: FloatArray
    peak_to_peak: FloatArray
    pinion_z: FloatArray
    pinion_r: FloatArray
    gear_z: FloatArray
    gear_r: FloatArray
    normal_backlash: FloatArray
    tangency: Codes
    jammed: Mask

    @property
    def solved(self) -> Mask:
        """Mountings with a path on the flanks."""
        return np.asarray(self.status == Status.SOLVED)

    def quantities(self) -> dict[str, FloatArray]:
        """Return the quantities (n,) whose distribution a study reports, by name; mm and rad."""
        names = "contact_ratio", "peak_to_peak", "normal_backlash"
        values = {name: getattr(self, name) for name in names}
        for name in ("pinion_z", "gear_z"):
            values |= {f"{name}_{place}": getattr(self, name)[:, k] for k, place in enumerate(PLACES)}
        return values


def solved_mountings(
    design: Design, flanks: Sequence[str], errors: FloatArray, names: Sequence[str]
) -> list[Mountings]:
    """Compute paths and backlash of mountings.

    Parameters
    ----------
    design : Design
        A single design.
    flanks : sequence of str
        Driving flanks, 'right' or 'left'.
    errors : ndarray, shape (n, names)
        Errors of the mountings, mm or rad.
    names : sequence of str
        Names of the errors.

    Returns
    -------
    list of Mountings
        One for each flank.
    """
    cases = mounted(design, errors, names)
    paths = {flank: path_of_contact(cases, flank, PATH_POINTS) for flank in flanks}
    backlash = tangent_backlash(cases, {flank: path.ends for flank, path in paths.items()})
    return [_mountings(path, backlash, errors) for path in paths.values()]


def _mountings(path: ContactPath, backlash: TangentBacklash, errors: FloatArray) -> Mountings:
    at = [0, PATH_POINTS // 2, PATH_POINTS - 1]
    module = float(path.design.pinion.tool.normal_module)
    return Mountings(
        errors=errors,
        status=path.ends.status,
        limit=path.ends.limit,
        pieces=path.ends.pieces,
        contact_ratio=path.ends.contact_ratio,
        peak_to_peak=swing_of(path.transmission_error),
        pinion_z=path.pinion_z[:, at],
        pinion_r=path.pinion_r[:, at],
        gear_z=path.gear_z[:, at],
        gear_r=path.gear_r[:, at],
        normal_backlash=backlash.normal,
        tangency=backlash.status,
        jammed=jammed(backlash.normal, module),
    )


def swing_of(values: FloatArray) -> FloatArray:
    """Return the peak-to-peak value (...) of smooth curves through values (..., points) at equal steps."""
    place = np.broadcast_to(np.arange(values.shape[-1], dtype=float), values.shape)
    (_, least), (_, most) = (least_along(place, sign * values) for sign in (1.0, -1.0))
    return np.asarray(-least - most)
