"""Edge contact of a design in several mountings: an estimate from the paths, and the mesh cycles.

At the end of its path, the contact of a tooth pair continues on an edge. The edge touches unless another
tooth pair, some pitches further on the same path, is ahead. With the transmission error e of the path
(positive: gear ahead) and the pitch p of the pinion,

    lead = max over k of e(phi_end + s k p) - e(phi_end),   k = 1, 2, ... within the path,

where phi_end is the roll at this end, and s = 1 or -1 points from this end into the path.

A mesh cycle has no edge contact if two conditions are met: the leads at both ends of the path are positive,
and edges can touch only where a path ends. `leads_of` assumes the second condition; `cycle_extremes` computes
the mesh cycle and needs no assumption."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..contact.path import ContactPath
from ..design.model import Design
from ..operation.mesh_cycle import mesh_cycle
from .sliding import least_along


@dataclass(frozen=True)
class CycleExtremes:
    """Mesh cycles of all teeth of a design in several mountings; NaN if one has no first contact.

    Attributes
    ----------
    cycle_peak_to_peak : float
        Peak-to-peak transmission error in the first mounting, rad.
    greatest_cycle_peak_to_peak : float
        Largest peak-to-peak transmission error of all mountings, rad.
    edge_share : float
        Largest share of a cycle in which edges touch.
    """

    cycle_peak_to_peak: float = np.nan
    greatest_cycle_peak_to_peak: float = np.nan
    edge_share: float = np.nan


def cycle_extremes(mountings: Design, flank: str) -> CycleExtremes:
    """Compute the mesh cycles of a design with single members and errors (n,); about 10 ms each.

    Parameters
    ----------
    mountings : Design
        The design with the errors of all mountings; `cycle_peak_to_peak` is that of the first mounting.
    flank : {'right', 'left'}

    Returns
    -------
    CycleExtremes

    Raises
    ------
    ValueError
        For members of arrays, and if the tip rounds of a tool overlap.
    """
    cycle = mesh_cycle(mountings, flank, 1)
    swing = cycle.peak_to_peak.ravel()
    return CycleExtremes(float(swing[0]), float(swing.max()), float(cycle.edge_share.max()))


def leads_of(path: ContactPath) -> FloatArray:
    """Return the leads of other tooth pairs where a path, evenly spaced in roll, enters and leaves.

    Parameters
    ----------
    path : ContactPath
        One path or a batch.

    Returns
    -------
    ndarray, shape (2, ...)
        rad. At contact ratios up to 1, at most one of both is positive. NaN without a path.
    """
    error = path.transmission_error
    ratio = path.ends.contact_ratio
    most = int(np.nan_to_num(ratio).max(initial=1.0))
    leads = []
    for values in (error, error[..., ::-1]):
        ahead = [_at(values, np.minimum(k / np.maximum(ratio, 1.0), 1.0)) for k in range(1, max(most, 1) + 1)]
        ahead[1:] = [np.where(k <= ratio, one, -np.inf) for k, one in enumerate(ahead[1:], start=2)]
        leads.append(np.max(ahead, axis=0) - values[..., 0])
    return np.array(leads)


def swing_of_all(path: ContactPath) -> FloatArray:
    """Return the peak-to-peak transmission error (...), rad, of all teeth without edge contact, from a
    path evenly spaced in roll. It is the largest transmission error of the path minus that at the roll at
    which the next tooth pair takes over. NaN without a path."""
    error = path.transmission_error
    pitch = 1.0 / np.maximum(np.nan_to_num(path.ends.contact_ratio), 1.0)  # shares of the path
    low, high = np.zeros(pitch.shape), 1.0 - pitch

    def ahead(share: FloatArray) -> FloatArray:
        """Return the lead of this pair over the pair one pitch further."""
        return _at(error, share) - _at(error, share + pitch)

    # Secant method between the share 0, at which this pair enters, and the share 1 - pitch, at which the pair
    # one pitch further leaves. Six steps are enough because the transmission error is nearly a parabola.
    last, share = low, high
    before, value = ahead(last), ahead(share)
    for _ in range(6):
        with np.errstate(invalid="ignore", divide="ignore"):
            step = value * (share - last) / (value - before)
        step = np.nan_to_num(step, posinf=0.0, neginf=0.0)
        last, before, share = share, value, np.clip(share - step, low, high)
        value = ahead(share)
    places = np.broadcast_to(np.linspace(0.0, 1.0, error.shape[-1]), error.shape)
    return np.asarray(_at(error, least_along(places, -error)[0]) - _at(error, share))


def _at(values: FloatArray, share: FloatArray) -> FloatArray:
    """Return values (...) at shares (...) of a path with values (..., positions) at even steps, by Lagrange
    polynomials through six positions."""
    steps = values.shape[-1] - 1
    place = np.nan_to_num(share) * steps
    # Number of positions used for interpolation; with 17 positions of a path the error is 1e-13 rad.
    neighbours = 6
    first = np.clip(np.floor(place).astype(int) - (neighbours // 2 - 1), 0, steps + 1 - neighbours)
    interpolated: FloatArray = np.zeros(np.shape(place))
    for j in range(neighbours):
        others = [k for k in range(neighbours) if k != j]
        weight = np.prod([(place - first - k) / (j - k) for k in others], axis=0)
        interpolated += weight * np.take_along_axis(values, (first + j)[..., None], axis=-1)[..., 0]
    return interpolated
