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
from ..design.model import Design
from ..gear.tooth_side import cut_at
from ..status import FirstStatus, Status, Verdict
from ..support.few_lines import few_lines
from .first_contact import FirstContact, first_contact, mesh_of
from .least_clearance import local_at
from .mesh_cycle import mesh_cycle

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
    first = first_contact(design, path.flank, roll) if few else mesh_cycle(design, path.flank, 1).at(roll)
    solved &= first.status == FirstStatus.SOLVED
    ahead = np.remainder(first.gear_roll - path.gear_roll + np.pi, 2.0 * np.pi) - np.pi
    separation = np.where(solved, ahead * _moment(design, path.flank, roll, first), np.nan)
    curvature = np.where(solved, _curvature(path, roll), np.nan)
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


def _moment(design: Design, flank: str, roll: FloatArray, first: FirstContact) -> FloatArray:
    """Give the moment (mm, signed) about the gear's axis of the normal along which the first contacts part:
    the gear's, but where only edges of the gear touch that of the pinion's surface under them."""
    mesh, _ = mesh_of(design, flank, roll)
    own, other, pose = mesh.own, mesh.other, mesh.pose
    with np.errstate(invalid="ignore"):
        gear = other.pitch_radius * cut_at(other, first.l2, first.z2).ny
        cut = cut_at(own, first.l1, first.z1)
        turn = cut.phi + roll + mesh.pitch[0] * first.pair
        nx, ny = cut.nx * np.cos(turn) - cut.ny * np.sin(turn), cut.nx * np.sin(turn) + cut.ny * np.cos(turn)
        x, y, z = np.moveaxis(first.point, -1, 0)
        sin, cos, x = (
            pose.sin.reshape(roll.shape),
            pose.cos.reshape(roll.shape),
            x - pose.offset.reshape(roll.shape),
        )
        # k2 x (R - O2) with k2 = (0, sin d, cos d), against the pinion's outward normal
        pinion = -(nx * (sin * z - cos * y) + ny * cos * x - cut.nz * sin * x)
    edges = first.limit
    of_gear = (edges[..., 0] >= 0) & ((edges < 0) | (edges % 2 == 1)).all(axis=-1)
    return np.asarray(np.where(of_gear, pinion, gear))


def _curvature(path: ContactPath, roll: FloatArray) -> FloatArray:
    """Give the lesser curvature (1/mm) of the clearance by the pinion's (l1, z1) at the positions."""
    mesh, _ = mesh_of(path.design, path.flank, roll)
    position = np.arange(roll.size)
    with np.errstate(invalid="ignore"):
        task = mesh.task(position, np.zeros_like(position))
        # The path is one of flanks: at the joint rounding must not make a fillet of it.
        l1 = np.maximum(path.l1.reshape(-1), mesh.own.joint + JOINT * mesh.module)
        (a, b), (_, c) = local_at(task, l1, path.pinion_z.reshape(-1)).bend
        lesser = 0.5 * (a + c) - np.hypot(0.5 * (a - c), b)
    return np.asarray(lesser.reshape(roll.shape))
