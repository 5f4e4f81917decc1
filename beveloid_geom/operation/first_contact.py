"""First contact of the teeth as the gear rotates towards the pinion, edges and fillets included.

At a given pinion roll, the first contact is the minimum of the clearance f(s1, z1) (`search.local_clearance`)
over all points within the limits of both members, on any of the neighbouring teeth. It lies

    on no limit      a tangency of flanks or fillets
    on one limit     an edge on the surface of the mate
    on two limits    a corner, or an edge on an edge.

The result is the contact of the solid teeth as long as the tips do not reach the bottom lands (MEETS_BOTTOM).
Tip lands and end faces are surfaces of revolution, so that they touch at their edges first. Flanks extend up
to the tip cone, also on pointed teeth. The opposite flank is not considered; if the backlash is negative, it
touches earlier."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Codes, FloatArray, Integers, Mask
from ..design.arguments import require_design
from ..design.field_limits import float64_of
from ..design.model import Design
from ..design.written_numbers import shown_value
from ..gear.tooth_side import cut_at
from ..support.array_repr import short_repr
from .engagement import Engagement, engagement_of
from .search.earliest_contact import Found, found_at, grids_of, in_step


@dataclass(frozen=True, eq=False)
class FirstContact:
    """First contacts at given pinion rolls, arrays (..., positions).

    Attributes
    ----------
    pinion_roll, gear_roll : ndarray
        Rolls of pinion and gear, rad.
    pair : ndarray of int
        Tooth pair that touches: pair k consists of pinion tooth k and gear tooth -k, counted in the direction
        of positive rotation. If several touch at the same time, a tangency is selected before an edge, and
        then the pair that came into mesh last. 0 where not solved.
    l1, l2 : ndarray
        Profile coordinates on pinion and gear, mm (s1, s2 in `search` and `cycle`): the flank parameter above
        the joint with the fillet, the fillet coordinate below (`gear.tooth_side`).
    z1, z2 : ndarray
        Distances from mid-face, mm.
    point : ndarray, shape (..., 3)
        Contact point in the fixed frame S_f, mm.
    limit : ndarray of int, shape (..., 2)
        Codes of `Limit` of the edges that touch, -1 for none. A contact without edges is a tangency.
    on_fillet : ndarray of bool, shape (..., 2)
        Whether the contact lies on the fillet of pinion and gear.
    transmission_error : ndarray
        Gear roll plus N1/N2 pinion roll, minus this sum for the unmodified pair without errors, times -1 on
        right flanks and +1 on left flanks, rad. It is positive where the gear is ahead in the sense of
        driving. The first contact has the largest error of all tooth pairs.
    status : ndarray of int
        Codes of `FirstStatus`. Where it is not SOLVED, all arrays of real numbers except `pinion_roll` are
        NaN, `pair` is 0, `limit` is -1 and `on_fillet` is False.
    """

    __repr__ = short_repr

    pinion_roll: FloatArray
    gear_roll: FloatArray
    pair: Integers
    l1: FloatArray
    z1: FloatArray
    l2: FloatArray
    z2: FloatArray
    point: FloatArray
    limit: Codes
    on_fillet: Mask
    transmission_error: FloatArray
    status: Codes

    def shaped(self, *shape: int) -> FirstContact:
        """Return the same positions in another shape."""
        last = {"point": (3,), "limit": (2,), "on_fillet": (2,)}
        return FirstContact(**{n: x.reshape(*shape, *last.get(n, ())) for n, x in vars(self).items()})


def first_contact(
    design: Design, flank: str = "right", pinion_roll: ArrayLike = 0.0, pairs: ArrayLike | None = None
) -> FirstContact:
    """Compute the first contact of all teeth at given pinion rolls: flanks, edges and fillets.

    Parameters
    ----------
    design : Design
        The fields of the members must not be arrays; pair and errors may be arrays.
    flank : {'right', 'left'}
    pinion_roll : array_like, shape (positions) or batch shape and positions
        rad.
    pairs : array_like of int, optional
        Numbers of the tooth pairs that are searched. If omitted, all tooth pairs that can touch are searched.
        A tooth that extends around its axis by more than one turn belongs to a different pair on each turn.

    Returns
    -------
    FirstContact

    Raises
    ------
    ValueError
        If a field of a member is an array, if rolls are not finite or of another shape, or if pairs are not
        whole numbers.

    References
    ----------
    Method: beveloid_geom/operation/README.md.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> first = bg.first_contact(bg.builtin_design("ni-2017"), "right", [0.0, 0.1])
    >>> first.pinion_roll
    array([0. , 0.1])
    """
    require_design(design)
    if pairs is not None and np.size(pairs) and not np.issubdtype(np.asarray(pairs).dtype, np.integer):
        raise ValueError(f"pairs must contain whole numbers, got {shown_value(pairs)}")
    shape = design.batch_shape
    roll = np.atleast_1d(float64_of("pinion_roll", pinion_roll))
    if not np.isfinite(roll).all():
        raise ValueError("pinion_roll must contain finite numbers")
    if roll.shape[:-1] not in ((), shape):
        raise ValueError(
            f"pinion_roll must have the shape (positions) or {(*shape, 'positions')}, got {roll.shape}"
        )
    roll = np.broadcast_to(roll, (*shape, roll.shape[-1]))
    return first_contact_in(design, flank, *engagement_of(design, flank, roll), roll.shape, pairs)


def first_contact_in(
    design: Design,
    flank: str,
    engagement: Engagement,
    phase: FloatArray,
    shape: tuple[int, ...],
    pairs: ArrayLike | None = None,
) -> FirstContact:
    """Compute first contacts for a known engagement.

    Parameters
    ----------
    design : Design
    flank : {'right', 'left'}
    engagement : Engagement
    phase : ndarray, shape (n,)
        Conjugate phase, rad, as returned by `engagement_of`.
    shape : tuple of int
        Shape of the positions, batch axes first.
    pairs : array_like of int, optional
        Numbers of the tooth pairs that are searched.

    Returns
    -------
    FirstContact
        Of this shape.
    """
    grids = grids_of(engagement, design, flank)
    if np.isnan(phase).any():
        engagement = in_step(engagement, np.isnan(phase).reshape(-1, shape[-1]), grids)
    return result_of(engagement, phase, found_at(engagement, grids, pairs), shape)


def result_of(
    engagement: Engagement, phase: FloatArray, contacts: Found, shape: tuple[int, ...]
) -> FirstContact:
    """Convert contacts found by the search to `FirstContact`, with points in S_f and the gear roll.

    Parameters
    ----------
    engagement : Engagement
        Positions (n,).
    phase : ndarray, shape (n,)
        Conjugate phase, rad; NaN where there is none.
    contacts : Found
        Contacts (n,).
    shape : tuple of int
        Shape of the positions, batch axes first.

    Returns
    -------
    FirstContact
    """
    (l1, z1), (l2, z2) = contacts.place, contacts.meeting
    with np.errstate(invalid="ignore"):
        cut = cut_at(engagement.pinion, l1, z1)
        turned = cut.phi + engagement.roll + contacts.pair * engagement.pitch[0]
    cos, sin = np.cos(turned), np.sin(turned)
    point = (cos * cut.x - sin * cut.y, sin * cut.x + cos * cut.y, z1 + engagement.axes.position[0])
    # Rotation of the gear from the conjugate roll.
    turn = engagement.gear.sigma * contacts.f / engagement.lever
    rows = {"l1": l1, "z1": z1, "l2": l2, "z2": z2, "pair": contacts.pair, "status": contacts.status}
    rows |= {
        "pinion_roll": engagement.roll,
        "gear_roll": engagement.phase - engagement.pitch[1] / engagement.pitch[0] * engagement.roll + turn,
        "transmission_error": -engagement.gear.sigma * (turn + engagement.phase - phase),
    }
    fillets = np.moveaxis(engagement.on_fillets((l1, z1), (l2, z2)), 0, -1)
    return FirstContact(
        point=np.stack(point, axis=-1).reshape(*shape, 3),
        limit=contacts.limit.T.reshape(*shape, 2),
        on_fillet=fillets.reshape(*shape, 2),
        **{name: value.reshape(shape) for name, value in rows.items()},
    )
