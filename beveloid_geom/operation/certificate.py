"""Certificate of a path of contact: whether the tangencies are contacts of the teeth.

Two flanks are tangent on the path of contact. They touch there only if no other part of the teeth touches
earlier. `path_certificate` compares each position with the first contact at the same pinion roll
(`first_contact`), which considers flanks, fillets and edges of all neighbouring teeth. For many positions,
the first contacts are evaluated from a mesh cycle (`mesh_cycle`).

With both parabola coefficients positive, the right flanks of Table 1 are tangent without being in contact:
from about 0.0002 1/mm, edges touch earlier nearly everywhere. From 0.0006 1/mm, the tangency is a saddle
point of the clearance at which the flanks intersect.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray, flank_sign
from ..contact.path import ContactPath
from ..design.arguments import require_path
from ..status import FirstStatus, Status, Verdict
from ..support.array_repr import short_repr
from .angular_clearance import without_turns
from .contact_normals import contact_normals, moved_by_gear
from .engagement import Engagement, engagement_of
from .first_contact import FirstContact, first_contact_in
from .mesh_cycle import mesh_cycle
from .search.local_clearance import local_at

OVERLAP_TOLERANCE_MODULES = 2e-7
"""Overlap that a certified contact may have, modules: 1.2e-6 mm on Table 1."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """Verdicts on the positions of a path of contact, arrays (..., positions).

    Attributes
    ----------
    separation : ndarray
        Smallest clearance between the teeth of gear and pinion at the rolls of the position, mm along the
        normal; negative for overlap, and then exact to first order.
    first : FirstContact
        First contact at the pinion roll of the position. The clearance is smallest at this contact.
    curvature : ndarray
        Smaller eigenvalue of the second derivatives of the clearance by the pinion's l1 and z1 at the
        tangency, 1/mm; negative where the flanks intersect.
    verdict : ndarray of int
        Codes of `Verdict`.

    Notes
    -----
    `separation` and `curvature` are NaN where the position or its first contact is not solved. The verdict is
    then NOT_SOLVED. It is also NOT_SOLVED if `separation` is larger than OVERLAP_TOLERANCE_MODULES modules.
    """

    __repr__ = short_repr

    separation: FloatArray
    first: FirstContact
    curvature: FloatArray
    verdict: Codes

    @property
    def holds(self) -> bool:
        """Return whether there are positions and all of them are first contacts."""
        return self.verdict.size > 0 and bool((self.verdict == Verdict.FIRST_CONTACT).all())


def path_certificate(path: ContactPath) -> Certificate:
    """Compare a path of contact with the first contacts of the teeth.

    Parameters
    ----------
    path : ContactPath

    Returns
    -------
    Certificate
        `holds` is true if no tooth, edge or fillet of this side touches before the flanks.

    Raises
    ------
    ValueError
        If a field of a member is an array; pair and errors may be arrays.

    References
    ----------
    Method: beveloid_geom/operation/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> bg.path_certificate(bg.path_of_contact(bg.builtin_design("ni-2017"))).holds
    True
    """
    require_path(path)
    # Number of positions from which a mesh cycle costs less than searches at the positions.
    mesh_cycle_positions = 40
    design, solved = path.design, path.status == Status.SOLVED
    roll = np.where(solved, path.pinion_roll, 0.0)
    few = roll.shape[-1] < mesh_cycle_positions
    if few:
        engagement, phase = engagement_of(design, path.flank, roll)
        first = first_contact_in(design, path.flank, engagement, phase, roll.shape)
    else:
        cycle = mesh_cycle(design, path.flank, 1)
        case = np.arange(cycle.start.size).repeat(roll.shape[-1])
        first, engagement = cycle.at(roll), cycle.engagement.at(case, roll.ravel())
    solved &= first.status == FirstStatus.SOLVED
    ahead = without_turns(first.gear_roll - path.gear_roll)
    moment = (contact_normals(design, path.flank, first) * moved_by_gear(design, first.point)).sum(axis=-1)
    # The normal of an edge on an edge can have either sense. All other moments have the sign of the flank.
    moment = flank_sign(path.flank) * np.abs(moment)
    separation = np.where(solved, ahead * moment, np.nan)
    curvature = np.where(solved, _curvature(path, engagement), np.nan)
    tangent, same = first.limit[..., 0] < 0, first.pair == 0
    module = float(design.gear.tool.normal_module)
    saddle = curvature < -6e-10 / module
    within = (tangent & same) | first.on_fillet.any(axis=-1)
    cases = (
        # The position touches, so that the smallest clearance cannot be positive.
        (~solved | (separation > OVERLAP_TOLERANCE_MODULES * module), Verdict.NOT_SOLVED),
        (separation >= -OVERLAP_TOLERANCE_MODULES * module, Verdict.FIRST_CONTACT),
        (saddle | within, Verdict.INTERFERENCE),
        (~tangent, Verdict.EDGE_CONTACT),
    )
    verdict = np.select([case for case, _ in cases], [code for _, code in cases], Verdict.NEXT_PAIR)
    return Certificate(separation, first, curvature, verdict.astype(np.int8))


def _curvature(path: ContactPath, engagement: Engagement) -> FloatArray:
    """Return the smaller eigenvalue (1/mm) of the second derivatives of the clearance along a path."""
    position = np.arange(engagement.roll.size)
    with np.errstate(invalid="ignore"):
        on_flanks = np.zeros((2, position.size), dtype=bool)
        task = engagement.task(position, np.zeros_like(position), on_flanks)
        # The path lies on the flanks: rounding must not place it on the fillet at the joint.
        l1 = np.maximum(path.l1.reshape(-1), engagement.pinion.joint + 2e-10 * engagement.module)
        a, b, c = local_at(task, l1, path.pinion_z.reshape(-1)).bend
        lesser = 0.5 * (a + c) - np.hypot(0.5 * (a - c), b)
    return np.asarray(lesser.reshape(path.l1.shape))
