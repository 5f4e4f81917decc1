"""Whether the tangencies of a path of contact are contacts of the teeth.

The path of contact is where two flanks are tangent. It is where they touch only if nothing else
of the teeth does before. `certify` compares each position with the first contact at the same
roll of the pinion (`first_contact`), over flanks, fillets and edges of all neighbouring teeth. Those of
many positions are values of a mesh cycle (`mesh_cycle`).

With both parabola coefficients positive the right flanks of Table 1 are tangent and yet not in
contact: from about 0.0002 1/mm edges touch earlier nearly everywhere, and from 0.0006 on the
tangency is a saddle of the clearance, at which the flanks pass through each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Codes, FloatArray
from ..contact.path import ContactPath
from ..status import FirstStatus, Status, Verdict
from ..support.few_lines import few_lines
from .first_contact import FirstContact, Mesh, contact_normals, first_contact_in, mesh_of, moved_by_gear
from .least_clearance import local_at
from .mesh_cycle import mesh_cycle
from .separation import without_turns

TOLERANCE = 2e-7
"""Modules of overlap that a contact is allowed: 1.2e-6 mm on Table 1."""
SADDLE = 6e-10
"""Over the module: curvature of the clearance that counts as negative."""

FEW = 40
"""Positions of a path below which searches for them cost less than a mesh cycle."""
JOINT = 2e-10
"""Modules above the joint with the fillet, from where on a point is taken to be on the flank."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """Verdicts on the positions of a path, arrays (*batch, positions).

    `separation` (mm along the normal): least clearance of the gear's teeth from the pinion's at the
    pose of the position, negative for overlap, to first order in it; `first`: the first contact
    at this roll of the pinion, where the least clearance is; `curvature` (1/mm): the lesser
    curvature of the clearance at the tangency, negative where the flanks pass through each other;
    `verdict`: codes of `Verdict`. NaN where not solved."""

    __repr__ = few_lines

    separation: FloatArray
    first: FirstContact
    curvature: FloatArray
    verdict: Codes

    @property
    def holds(self) -> bool:
        """Say whether there are positions and every one is the first contact."""
        return self.verdict.size > 0 and bool((self.verdict == Verdict.FIRST_CONTACT).all())


def certify(path: ContactPath) -> Certificate:
    """Compare a path of contact with the first contacts of the teeth of its design.

    Parameters
    ----------
    path : ContactPath

    Returns
    -------
    Certificate
        `holds`: whether no tooth, edge or fillet of this side touches before the flanks do.

    Raises
    ------
    ValueError
        For members of arrays; pair and errors may be arrays.
    """
    design, solved = path.design, path.status == Status.SOLVED
    roll = np.where(solved, path.pinion_roll, 0.0)
    few = roll.shape[-1] < FEW
    if few:
        mesh, phase = mesh_of(design, path.flank, roll)
        first = first_contact_in(design, path.flank, mesh, phase, roll.shape)
    else:
        cycle = mesh_cycle(design, path.flank, 1)
        case = np.arange(cycle.start.size).repeat(roll.shape[-1])
        first, mesh = cycle.at(roll), cycle.mesh.at(case, roll.ravel())
    solved &= first.status == FirstStatus.SOLVED
    ahead = without_turns(first.gear_roll - path.gear_roll)
    moment = (contact_normals(design, path.flank, first) * moved_by_gear(design, first.point)).sum(axis=-1)
    separation = np.where(solved, ahead * moment, np.nan)
    curvature = np.where(solved, _curvature(path, mesh), np.nan)
    tangent, same = first.limit[..., 0] < 0, first.pair == 0
    module = float(design.gear.tool.normal_module)
    saddle = curvature < -SADDLE / module
    within = (tangent & same) | first.on_fillet.any(axis=-1)
    cases = (
        # Nothing is further off than the position itself, which touches.
        (~solved | (separation > TOLERANCE * module), Verdict.NOT_SOLVED),
        (separation >= -TOLERANCE * module, Verdict.FIRST_CONTACT),
        (saddle | within, Verdict.INTERFERENCE),
        (~tangent, Verdict.EDGE_CONTACT),
    )
    verdict = np.select([case for case, _ in cases], [code for _, code in cases], Verdict.NEXT_PAIR)
    return Certificate(separation, first, curvature, verdict.astype(np.int8))


def _curvature(path: ContactPath, mesh: Mesh) -> FloatArray:
    """Give the lesser curvature (1/mm) of the clearance by the pinion's (l1, z1) along a path."""
    position = np.arange(mesh.roll.size)
    with np.errstate(invalid="ignore"):
        task = mesh.task(position, np.zeros_like(position))
        # The path is one of flanks: at the joint rounding must not make a fillet of it.
        l1 = np.maximum(path.l1.reshape(-1), mesh.own.joint + JOINT * mesh.module)
        a, b, c = local_at(task, l1, path.pinion_z.reshape(-1)).bend
        lesser = 0.5 * (a + c) - np.hypot(0.5 * (a - c), b)
    return np.asarray(lesser.reshape(path.l1.shape))
