"""Status codes of results, and the reason of a result that could not be computed."""

from __future__ import annotations

from enum import IntEnum


class NotComputed(str):
    """Reason for a missing result whose calculation failed.

    A reason that is a plain `str` is a result itself, for example that a pair has no contact."""

    __slots__ = ()


class Status(IntEnum):
    """Result of the contact equation at one position, or over a path."""

    SOLVED = 0
    NO_COMMON_NORMAL = 1
    """The flanks have no common normal at this l1 (flank parameter of the pinion, mm), or none with which
    they can touch. For a path: no contact was found near the flanks, and some of their points have no common
    normal."""
    NOT_CONVERGED = 2
    """Not solved to rounding. For a path: the curve was lost or not resolved on the flanks."""
    OFF_FLANK = 3
    """The extended flanks touch outside root, tip, toe or heel of a member; values are NaN if the contact is
    further away than the depth of a flank. For a path: no part of it is on the flanks."""
    SEVERAL_CONTACTS = 4
    """More than one contact on the flanks for this l1."""
    ENDLESS = 5
    """Only for a path: it is a closed curve on the flanks and meets no limit."""
    UNDEFINED = 6
    """The inputs define no problem: a member that its tool cannot cut, a pair without pitch point (its
    unmodified flanks have no common normal), or NaN."""


class Limit(IntEnum):
    """Limits of the active flanks, in the order of `limit_margins`.

    TOE is the end of the face at -z and HEEL the end at +z of that member, whatever its cone angle;
    `design.ends` has their names in print, where the heel is the large end."""

    PINION_ROOT = 0
    GEAR_ROOT = 1
    PINION_TIP = 2
    GEAR_TIP = 3
    PINION_TOE = 4
    GEAR_TOE = 5
    PINION_HEEL = 6
    GEAR_HEEL = 7

    def __str__(self) -> str:
        """Return the code in words; TOE and HEEL are named by z, not by size."""
        return f"{self.member} {self.limit}"

    @property
    def member(self) -> str:
        """'pinion' or 'gear'."""
        return self.name.split("_")[0].lower()

    @property
    def limit(self) -> str:
        """'root', 'tip', 'toe' (the end at -z) or 'heel' (the end at +z)."""
        return self.name.split("_")[1].lower()


class FirstStatus(IntEnum):
    """Result of the search for the first contact: the gear roll at which, at a pinion roll, the first of all
    teeth touches."""

    SOLVED = 0
    NO_CONTACT = 1
    """No tooth has points within the limits of both members."""
    NOT_CONVERGED = 2
    MEETS_BOTTOM = 3
    """A tip reaches down to the other member's bottom land."""
    UNDERCUT = 4
    """Undercut removes a flank completely in a part of the face."""
    OUT_OF_STEP = 5
    """The gear is so far from the contact of the unmodified pair without errors that the tooth pair is not
    certain: an overlap of two teeth cannot be distinguished from their clearance one turn later. This happens
    with few teeth."""
    UNDEFINED = 6
    """The inputs define no problem: a member that its tool cannot cut, a pair without pitch point (its
    unmodified flanks have no common normal), or NaN."""

    @property
    def reason_type(self) -> type[str]:
        """Type of a reason with this status: `NotComputed`, or `str` if a missing contact is the result."""
        return str if self in (FirstStatus.NO_CONTACT, FirstStatus.MEETS_BOTTOM) else NotComputed


WHY_NO_FIRST_CONTACT = {
    FirstStatus.NO_CONTACT: "no tooth reaches the other member",
    FirstStatus.MEETS_BOTTOM: "a tip reaches the other member's bottom land",
    FirstStatus.UNDERCUT: "undercut removes a complete flank in a part of the face",
    FirstStatus.OUT_OF_STEP: "the roll angles are too far from mesh to distinguish the tooth pairs",
    FirstStatus.UNDEFINED: "the inputs do not define the teeth or their position",
    FirstStatus.NOT_CONVERGED: "the search did not converge",
    FirstStatus.SOLVED: "the search found only a later contact",
}
"""Reasons for an unknown first contact at a position. SOLVED: the first contact found is later than the
contact of the path."""


class Verdict(IntEnum):
    """Comparison of one position of a path with the first contact of all teeth."""

    FIRST_CONTACT = 0
    """Nothing touches earlier."""
    EDGE_CONTACT = 1
    """An edge touches earlier; the limits of the first contact name it."""
    NEXT_PAIR = 2
    """The flanks of another tooth pair touch earlier: this position is beyond the hand-over to the next
    pair."""
    INTERFERENCE = 3
    """The flanks overlap next to their point of tangency, or a tip or flank overlaps with a fillet."""
    NOT_SOLVED = 4
    """The position is not on the flanks, or no first contact was found."""


class RatioStatus(IntEnum):
    """Result of the calculation of a contact ratio in operation."""

    KNOWN = 0
    NO_FIRST_CONTACT = 1
    """A position of the cycle has no first contact."""
    NOT_CONVERGED = 2
    """At some roll the clearance of a single tooth pair was not computed."""
    TOO_THICK = 3
    """The film is too thick: tooth pairs count as in contact within the thickness of a film of lubricant or
    marking compound. It reaches tooth pairs that are not considered, or the same teeth one turn later."""
    UNSTEADY = 4
    """The rolls at which contact of a tooth pair begins and ends cannot be distinguished."""


class PatternStatus(IntEnum):
    """Kind of the smallest separation of one point over the roll."""

    STANDSTILL = 0
    """The derivative of the separation is zero."""
    MATE_EDGE = 1
    """The closest point is on an edge of the mating flank."""
    END_OF_ROLL = 2
    """The separation still decreases at the first or the last roll."""
    NO_MATE = 3
    """The point has no closest point on the mating flank at any roll; NaN."""


class EllipseStatus(IntEnum):
    """Result for the contact ellipse at one position."""

    ELLIPSE = 0
    LINE_CONTACT = 1
    """The smaller relative curvature is zero to rounding: the minor axis is finite, the major axis NaN."""
    INTERFERENCE = 2
    """A relative curvature is negative: the flanks overlap next to the point of contact."""
    NO_CONTACT = 3
    """The path has no contact on the flanks here."""


class PlaceStatus(IntEnum):
    """Result of the search for two errors that move the middle of a path to a required position."""

    REACHED = 0
    NOT_CONVERGED = 1
    """Newton's method found no such errors within the limits; all values are NaN."""
    OFF_CENTRE = 2
    """At the required position the pair cannot be assembled. The values belong to the nearest position in
    profile, at the same position along the face, at which the pair can be assembled."""
    NO_PATH = 3
    """Neither the design nor any mounting that was tried has a path; all values are NaN."""
    JAMMED = 4
    """The pair cannot be assembled at the required position, nor at any trial position up to a quarter of the
    profile depth away. All values are NaN, except for `Placement.exact`."""


class BallStatus(IntEnum):
    """Whether a ball between two teeth can be measured."""

    MEASURED = 0
    OFF_FLANK = 1
    """The ball touches outside root, tip, toe or heel, or where undercut has removed the flank."""
    BELOW_TIP = 2
    """The ball does not project beyond the tips and cannot be measured."""
    ON_BOTTOM = 3
    """The ball touches the bottom land before it touches both flanks."""
    NOT_FOUND = 4
    """No position at which the ball touches both flanks was found."""


class SpanStatus(IntEnum):
    """Whether a span over some teeth can be measured."""

    MEASURED = 0
    CONE = 1
    """Not defined: right and left flanks of a conical gear have different base helix angles."""
    PARABOLA = 2
    """Not defined: flanks with a parabola or a modification are not involutes."""
    OFF_FLANK = 3
    """The points of contact would be above the tip or below the form diameter."""
    FACE_TOO_NARROW = 4
    """The points of contact are further apart along the axis than the face is wide."""


class ShimStatus(IntEnum):
    """Result of the search for axial positions with a required backlash and position of the path."""

    REACHED = 0
    OUT_OF_REACH = 1
    """The positions are further away than the smaller face width."""
    NO_EFFECT = 2
    """Axial positions do not change the backlash: both members are cylindrical."""
    NO_PATH = 3
    """A position of the path is required, and no tried axial position has a path on the flanks."""
    NOT_FOUND = 4
    """A first contact was not computed, or no nearby positions meet both conditions."""


CODES_OF_FIELDS: dict[str, type[IntEnum]] = {
    field: codes
    for codes, names in {
        Status: "ContactPath.status PathEnds.status EaseOff.status Sliding.status Sensitivity.status"
        " Mountings.status DesignMap.status",
        Limit: "PathEnds.limit ContactLines.limit PathPressure.reaches FirstContact.limit Sensitivity.limit"
        " Mountings.limit",
        FirstStatus: "FirstContact.status MeshCycle.status Backlash.status PatternMatrix.status",
        EllipseStatus: "PathPressure.status",
        Verdict: "Certificate.verdict",
        RatioStatus: "OperatingRatios.status",
        PatternStatus: "MemberPattern.status",
        PlaceStatus: "Placement.status",
        BallStatus: "Balls.status",
        SpanStatus: "Span.status",
        ShimStatus: "Shim.status",
    }.items()
    for field in names.split()
}
"""Enumerations of the codes in results, by class and field."""
