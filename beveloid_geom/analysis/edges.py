"""Whether edges touch first in some mountings of a design: cheaply from their paths, surely in operation.

A tooth pair that comes to an end of its path goes on over an edge. The edge carries unless another tooth
pair is ahead there, some pitches further on the same path. With e the transmission error of the path,
p the pitch of the pinion and s = 1 on left flanks, -1 on right ones, where the gear turns back,

    lead = max over k of s [e(end, k p inwards) - e(end)],   k = 1, 2, ... within the path.

Edges carry nothing of a mesh cycle if the leads at both ends are positive and nothing but the end of a path
brings an edge to bear. That is assumed by `leads_of` alone; `operation_of` finds the mesh cycle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, flank_sign
from ..contact.path import ContactPath
from ..design.model import Design
from ..operation.mesh_cycle import mesh_cycle
from .sliding import least_along

PASSES = 6
"""Steps to where the next tooth pair takes over: transmission errors are next to parabolas."""
NEIGHBOURS = 6
"""Positions of a path through which a polynomial gives the values between: to 1e-13 rad of 17."""


@dataclass(frozen=True)
class Operation:
    """What all teeth of a design do over a mesh cycle in some mountings; NaN where one has no first contact.

    `cycle_peak_to_peak` (rad): greatest less least transmission error in the first mounting,
    `greatest_cycle_peak_to_peak` in any. `edge_share`: of the cycle, what edges carry, greatest over the
    mountings."""

    cycle_peak_to_peak: float = np.nan
    greatest_cycle_peak_to_peak: float = np.nan
    edge_share: float = np.nan


def operation_of(mountings: Design, flank: str) -> Operation:
    """Find the mesh cycles of a design with single members and errors (n,), some 10 ms each.

    Raises ValueError for members of arrays, and where a tool's rounds overlap."""
    cycle = mesh_cycle(mountings, flank, 1)
    swing = cycle.peak_to_peak.ravel()
    return Operation(float(swing[0]), float(swing.max()), float(cycle.edge_share.max()))


def leads_of(path: ContactPath) -> FloatArray:
    """Find the leads (2, *batch), rad, of other tooth pairs where a path, evenly spaced in roll, enters and
    leaves.

    Of a contact ratio up to 1 not both are positive. NaN without a path."""
    error = -flank_sign(path.flank) * path.transmission_error
    ratio = path.ends.contact_ratio
    most = int(np.nan_to_num(ratio).max(initial=1.0))
    leads = []
    for values in (error, error[..., ::-1]):
        ahead = [_at(values, np.minimum(k / np.maximum(ratio, 1.0), 1.0)) for k in range(1, max(most, 1) + 1)]
        ahead[1:] = [np.where(k <= ratio, one, -np.inf) for k, one in enumerate(ahead[1:], start=2)]
        leads.append(np.max(ahead, axis=0) - values[..., 0])
    return np.array(leads)


def swing_of_all(path: ContactPath) -> FloatArray:
    """Find the greatest less least transmission error (*batch), rad, of all teeth where no edge carries, by a
    path, evenly spaced in roll: down to where the next tooth pair takes over. NaN without a path."""
    error = -flank_sign(path.flank) * path.transmission_error
    pitch = 1.0 / np.maximum(np.nan_to_num(path.ends.contact_ratio), 1.0)  # shares of the path
    low, high = np.zeros(pitch.shape), 1.0 - pitch

    def ahead(share: FloatArray) -> FloatArray:
        """Give by how much this pair is ahead of the one a pitch further on."""
        return _at(error, share) - _at(error, share + pitch)

    # By secants from the share at which the next pair comes in and that at which this one leaves.
    last, share = low, high
    before, value = ahead(last), ahead(share)
    for _ in range(PASSES):
        with np.errstate(invalid="ignore", divide="ignore"):
            step = value * (share - last) / (value - before)
        step = np.nan_to_num(step, posinf=0.0, neginf=0.0)
        last, before, share = share, value, np.clip(share - step, low, high)
        value = ahead(share)
    places = np.broadcast_to(np.linspace(0.0, 1.0, error.shape[-1]), error.shape)
    return np.asarray(_at(error, least_along(places, -error)[0]) - _at(error, share))


def _at(values: FloatArray, share: FloatArray) -> FloatArray:
    """Find values (...) at shares (...) of the way from the first to the last of values (..., positions) at
    even steps."""
    steps = values.shape[-1] - 1
    place = np.nan_to_num(share) * steps
    first = np.clip(np.floor(place).astype(int) - (NEIGHBOURS // 2 - 1), 0, steps + 1 - NEIGHBOURS)
    found: FloatArray = np.zeros(np.shape(place))
    for j in range(NEIGHBOURS):  # Lagrange's polynomials
        others = [k for k in range(NEIGHBOURS) if k != j]
        weight = np.prod([(place - first - k) / (j - k) for k in others], axis=0)
        found += weight * np.take_along_axis(values, (first + j)[..., None], axis=-1)[..., 0]
    return found
