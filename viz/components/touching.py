"""First contacts of all teeth at the rolls of a path of contact, and edge contact up to its ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beveloid_geom import ContactPath, MeshCycle, Status, path_certificate
from beveloid_geom.arrays import Codes, FloatArray
from beveloid_geom.operation.first_contact import FirstContact
from beveloid_geom.operation.operating_ratio import operating_ratios
from beveloid_geom.status import Limit, Verdict

CHANGE_PITCHES = 1e-11
"""Distance of rolls on both sides of a change of the contact, and just beyond the ends of a path, in
pitches."""


@dataclass(frozen=True, eq=False)
class Touching:
    """First contact of all teeth at n rolls.

    Attributes
    ----------
    verdict : ndarray of int, shape (n,)
        `Verdict` of the certificate at positions of a path; NOT_SOLVED at other rolls.
    first : FirstContact
        First contact at the rolls.
    ratio : float
        Contact ratio of all teeth in operation; NaN if unknown.
    """

    verdict: Codes
    first: FirstContact
    ratio: float

    @property
    def edges(self) -> list[str]:
        """Edges in contact at each roll; '' for contact of flanks."""
        codes = np.where((self.verdict == Verdict.FIRST_CONTACT)[:, None], -1, self.first.limit)
        return [" on ".join(limit_code(code) for code in both if code >= 0) for both in codes.tolist()]

    def places(self, member: int) -> tuple[FloatArray, FloatArray]:
        """Return l and z (n,), mm, of edge contact on pinion (0) or gear (1); NaN on flanks and fillets."""
        first = self.first
        l, z = ((first.l1, first.z1), (first.l2, first.z2))[member]
        away = first.on_fillet[:, member] | (np.array(self.edges) == "")
        return np.where(away, np.nan, l), np.where(away, np.nan, z)


def joined_contacts(*parts: Touching | None) -> Touching:
    """Return the first contacts of all parts in the order of their rolls."""
    given = [part for part in parts if part]
    order = np.argsort(np.concatenate([part.first.pinion_roll for part in given]), kind="stable")
    columns = {
        name: np.concatenate([getattr(part.first, name) for part in given])[order]
        for name in vars(given[0].first)
    }
    verdict = np.concatenate([part.verdict for part in given])[order]
    return Touching(verdict, FirstContact(**columns), given[0].ratio)


def limit_code(code: int) -> str:
    """Return the code of a limit for tables, such as 'gear tip'; '' for no limit, -1."""
    return str(Limit(code)) if code >= 0 else ""


def touching_along(path: ContactPath, points: int) -> tuple[Touching, Touching | None]:
    """Compute the first contacts of all teeth along a path of contact.

    Parameters
    ----------
    path : ContactPath
        The path.
    points : int
        Number of rolls per pitch where there is no path.

    Returns
    -------
    at : Touching
        At the positions of the path. Without a path, over a mesh cycle.
    between : Touching or None
        At other rolls: on both sides of each change of the contact, and over the remainder of a pitch if the
        path is shorter than a pitch. None if there are no such rolls.
    """
    ratios = operating_ratios(path.design, path.flank, (0.0,))
    cycle, ratio = ratios.cycle, float(ratios.ratio[0])
    if not (path.status == Status.SOLVED).any():
        rolls = cycle.start + cycle.pitch * np.linspace(0.0, 1.0, points)
        return _over(cycle, np.sort(np.append(rolls, _next_to_changes(cycle, rolls))), ratio), None
    certificate = path_certificate(path)
    beyond = _remainder(path, cycle, points)
    rolls = np.append(beyond, _next_to_changes(cycle, np.append(beyond, path.ends.pinion_roll)))
    at = Touching(certificate.verdict, certificate.first, ratio)
    return at, _over(cycle, np.sort(rolls), ratio) if rolls.size else None


def _remainder(path: ContactPath, cycle: MeshCycle, points: int) -> FloatArray:
    """Return rolls (n,) from the end of a path to the start of the path of the next tooth pair; none if the
    path is at least a pitch long."""
    ratio, (enter, leave) = float(path.ends.contact_ratio), path.ends.pinion_roll.tolist()
    if not 0.0 < ratio < 1.0:
        return np.empty(0)
    enters_next = enter + np.copysign(float(cycle.pitch), leave - enter)
    # At the ends of the path the flanks are tangent within rounding, so the rolls start and end just beyond.
    share = np.linspace(CHANGE_PITCHES, 1.0 - CHANGE_PITCHES, 2 + int(points * (1.0 - ratio)))
    return np.asarray(leave + share * (enters_next - leave))


def _next_to_changes(cycle: MeshCycle, rolls: FloatArray) -> FloatArray:
    """Return rolls (n,), rad, on both sides of each change of the contact in the range of `rolls`.

    None along lines of contact, where changes are those of the point that represents a line."""
    # Distance below which a change of the contact is the end of a path, pitches.
    same_pitches = 1e-9
    changes = cycle.changes[np.isfinite(cycle.changes)]
    low, high = float(rolls.min()), float(rolls.max())
    if bool(cycle.along_lines) or not np.isfinite(low + high):
        return np.empty(0)
    start, pitch = float(cycle.start), float(cycle.pitch)
    turns = np.arange(np.floor((low - start) / pitch), np.ceil((high - start) / pitch))
    all_changes = (changes + cycle.pitch * turns[:, None]).ravel()
    margin = same_pitches * cycle.pitch
    within = all_changes[(low + margin < all_changes) & (all_changes < high - margin)]
    return np.asarray((within + CHANGE_PITCHES * cycle.pitch * np.array([[-1.0], [1.0]])).ravel())


def _over(cycle: MeshCycle, rolls: FloatArray, ratio: float) -> Touching:
    """Return the first contacts at rolls (n,), rad, of a mesh cycle without positions of a path."""
    return Touching(np.full(rolls.size, np.int8(Verdict.NOT_SOLVED)), cycle.at(rolls), ratio)
