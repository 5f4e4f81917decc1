"""What results say of themselves: every word, and what it means."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """What is known of one position."""

    SOLVED = 0
    NO_COMMON_NORMAL = 1
    """The flanks share no normal at this l1, or none under which they can touch; of a path: no contact
    was found near the flanks, and for some of their points there is no common normal."""
    NOT_CONVERGED = 2
    """Not found to rounding; of a path: lost, or not resolved on the flanks."""
    OFF_FLANK = 3
    """A contact of the flanks' extensions, outside root, tip, toe or heel of a member; NaN where it lies
    more than a flank's depth away. Of a path: none of it lies on the flanks."""
    SEVERAL_CONTACTS = 4
    """More than one contact on the flanks for this l1."""
    ENDLESS = 5
    """Of a path: it closes on itself on the flanks, without meeting a limit."""
    UNDEFINED = 6
    """The inputs leave nothing to solve: a member that its tool cannot cut, no layout, NaN."""


class Limit(IntEnum):
    """Limits of the active flanks, in the order of `limit_margins`."""

    PINION_ROOT = 0
    GEAR_ROOT = 1
    PINION_TIP = 2
    GEAR_TIP = 3
    PINION_TOE = 4
    GEAR_TOE = 5
    PINION_HEEL = 6
    GEAR_HEEL = 7

    def __str__(self) -> str:
        return f"{self.member} {self.limit}"

    @property
    def member(self) -> str:
        """'pinion' or 'gear'."""
        return self.name.split("_")[0].lower()

    @property
    def limit(self) -> str:
        """'root', 'tip', 'toe' or 'heel'."""
        return self.name.split("_")[1].lower()


class FirstStatus(IntEnum):
    """What is known of the first contact at one position."""

    SOLVED = 0
    NO_CONTACT = 1
    """No tooth has points within the limits of both members."""
    NOT_CONVERGED = 2
    MEETS_BOTTOM = 3
    """A tip reaches down to the other member's bottom land."""
    UNDERCUT = 4
    """A fillet reaches into its flank: the surfaces used here are not those of the tooth."""
    OUT_OF_STEP = 5
    """Few teeth, so far from where the unmodified pair without errors would touch that an overlap and
    the clearance of the next turn cannot be told apart."""
    UNDEFINED = 6
    """The inputs leave nothing to search: a member that its tool cannot cut, no layout, NaN."""


class Verdict(IntEnum):
    """What the tangency at one position of a path is."""

    FIRST_CONTACT = 0
    """Nothing touches earlier."""
    EDGE_CONTACT = 1
    """An edge touches earlier; the limits of the first contact name it."""
    NEXT_PAIR = 2
    """The flanks of another tooth pair touch earlier, in a tangency of their own: this position
    lies beyond the hand-over."""
    INTERFERENCE = 3
    """The flanks overlap beside their tangency, or a tip or flank stands in a fillet."""
    NOT_SOLVED = 4
    """No position on the flanks, or no first contact found."""


class RatioStatus(IntEnum):
    """What is known of an operating contact ratio."""

    KNOWN = 0
    NO_FIRST_CONTACT = 1
    """A position of the cycle has no first contact."""
    NOT_CONVERGED = 2
    """At a roll the clearance of a tooth pair taken alone is not known."""
    TOO_THICK = 3
    """The thickness reaches tooth pairs beyond those looked at, or the next turn of the same teeth."""
    UNSTEADY = 4
    """Rolls at which a tooth pair begins and ceases to touch cannot be told apart."""


class PatternStatus(IntEnum):
    """How the separation of one point comes to its least value."""

    STANDSTILL = 0
    """It stands still there."""
    MATE_EDGE = 1
    """The foot reaches an edge of the mating flank there."""
    END_OF_ROLL = 2
    """It still falls at the first or the last pose."""
    NO_MATE = 3
    """The point has no foot on the mating flank at any pose; NaN."""


class EllipseStatus(IntEnum):
    """What is known of the contact ellipse at one position."""

    ELLIPSE = 0
    LINE_CONTACT = 1
    """The smaller relative curvature is zero to rounding: the minor axis is given, the other is NaN."""
    INTERFERENCE = 2
    """A relative curvature is negative: the flanks cut each other beside the contact."""
    NO_CONTACT = 3
    """The path has no contact on the flanks here."""


class PlaceStatus(IntEnum):
    """Whether two errors put the middle of a path where it is wanted."""

    REACHED = 0
    OUT_OF_REACH = 1
    """None within the limits of the search do; what is given is the nearest."""
    OFF_CENTRE = 2
    """Centred in profile the pair cannot be assembled there; what is given is the same place on the face, and
    in profile the nearest at which it can, NaN if it cannot at any near."""
    NO_PATH = 3
    """No mounting within the limits of the search has a path."""


class BallStatus(IntEnum):
    """What a ball between two teeth is good for."""

    MEASURED = 0
    OFF_FLANK = 1
    """It touches outside root, tip, toe or heel, or where undercut has left nothing."""
    BELOW_TIP = 2
    """It does not stand out of the teeth: there is nothing to measure over."""
    ON_BOTTOM = 3
    """It would lie in the root cone: the bottom land stops it before both flanks do."""
    NOT_FOUND = 4
    """No place at which it touches both flanks."""


class ShimStatus(IntEnum):
    """Whether axial positions give the backlash, and the place of the path, that are wanted."""

    REACHED = 0
    OUT_OF_REACH = 1
    """They do, further away than the lesser face width."""
    NO_EFFECT = 2
    """Axial positions do not change the backlash: neither member has a cone."""
    NO_PATH = 3
    """A place is wanted, and at no position tried is there a path on the flanks."""
    NOT_FOUND = 4
    """None were found: a first contact on the way is not known, or nothing near meets both conditions."""
