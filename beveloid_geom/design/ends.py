"""Printed names of the ends of a face, and of the limits of a flank.

In code, JSON, CSV and the names of node and element sets (`.inp`), `toe` is the end at -z and `heel` the end
at +z of a member, whichever end is larger. In printed text the heel is the large end and the toe the small
end (ISO 1122, ISO 23509), so that the names are exchanged for a negative cone angle. Teeth without a cone
have no large end: the end at -z is called back, the end at +z front."""

from __future__ import annotations

from ..status import Limit
from .member import Member
from .model import Design


def end_names(member: Member) -> tuple[str, str]:
    """Return the printed names of the ends of a single member's face at -z and at +z.

    Parameters
    ----------
    member : Member
        Member of plain numbers.

    Returns
    -------
    tuple of str
        ('toe', 'heel') for a positive cone angle, ('heel', 'toe') for a negative one, ('back', 'front')
        without a cone.
    """
    cone = float(member.cone_angle)
    if cone == 0.0:
        return "back", "front"
    return ("toe", "heel") if cone > 0.0 else ("heel", "toe")


def limit_names(design: Design, limit: int) -> tuple[str, str]:
    """Return the printed names of the member and the limit for a limit of a single design's flanks.

    Parameters
    ----------
    design : Design
    limit : int
        Code of a `Limit`.

    Returns
    -------
    tuple of str
        Such as ('pinion', 'heel'); `Limit.limit` is the code of the limit.
    """
    code = Limit(limit)
    names = dict(zip(("toe", "heel"), end_names(getattr(design, code.member)), strict=True))
    return code.member, names.get(code.limit, code.limit)


def limit_words(design: Design, limit: int) -> str:
    """Return the printed name of a limit of a single design's flanks, such as 'gear tip' or 'pinion heel'.

    `str(Limit)` is the code, in which the ends are named by z.

    Parameters
    ----------
    design : Design
        A single design.
    limit : int
        Code of a `Limit`.

    Returns
    -------
    str
    """
    return " ".join(limit_names(design, limit))
