"""Checks of the design, member or path that a function of the library gets."""

from __future__ import annotations

import numbers
import os
from collections.abc import Sequence

import numpy as np

from .member import MODIFICATIONS, Member
from .model import Design
from .written_numbers import shown_value


def require_design(design: object) -> None:
    """Raise TypeError if an argument is not a `Design`.

    For the name of a file or of a built-in design, the message contains the call that reads it.

    Parameters
    ----------
    design : object
        The argument.

    Raises
    ------
    TypeError
        With a cure.
    """
    if isinstance(design, Design):
        return
    cure = "create one with Design(...) or read_design(file)"
    if isinstance(design, str | os.PathLike):
        cure = f"read it with read_design({os.fspath(design)!r})"
    raise TypeError(f"design must be a Design, got {_shown(design)}: {cure}")


def require_single(design: Design) -> None:
    """Raise TypeError if an argument is not a `Design`, and ValueError for a design with arrays."""
    require_design(design)
    if design.batch_shape:
        raise ValueError(f"design must be a single design, got arrays of shape {design.batch_shape}")


def require_member(member: object) -> None:
    """Raise TypeError if an argument is not a `Member`, with the parts of a design that are."""
    if not isinstance(member, Member):
        cure = "pass design.pinion or design.gear"
        raise TypeError(f"member must be a Member, got {_shown(member)}: {cure}")


def require_numbers(**arguments: object) -> None:
    """Raise TypeError if one of the named arguments is neither None nor a number."""
    for name, value in arguments.items():
        if value is not None and not _is_a(numbers.Real, value):
            raise TypeError(f"{name} must be a number, got {_shown(value)}")


def require_integers(**arguments: object) -> None:
    """Raise TypeError if one of the named arguments is neither None nor an integer."""
    for name, value in arguments.items():
        if value is not None and not _is_a(numbers.Integral, value):
            raise TypeError(f"{name} must be an integer, got {_shown(value)}")


def require_two_numbers(**arguments: object) -> None:
    """Raise TypeError if one of the named arguments is neither None nor a sequence of two numbers."""
    for name, value in arguments.items():
        two = value if isinstance(value, Sequence | np.ndarray) else ()
        if value is not None and not (len(two) == 2 and all(_is_a(numbers.Real, one) for one in two)):
            raise TypeError(f"{name} must be two numbers, got {_shown(value)}")


def _is_a(kind: type, value: object) -> bool:
    """Return whether a value, or the value of an array without dimensions, is a number of a kind."""
    return isinstance(value[()] if isinstance(value, np.ndarray) else value, kind)


def require_path(path: object) -> None:
    """Raise TypeError if an argument is not a path of contact: if it lacks `design` or `l1`."""
    if not hasattr(path, "design") or not hasattr(path, "l1"):
        cure = "pass the result of path_of_contact(design)"
        raise TypeError(f"path must be a ContactPath, got {_shown(path)}: {cure}")


def _shown(value: object) -> str:
    """Return a value for a message, a result of the library by its class."""
    return f"a {type(value).__name__}" if hasattr(value, "__dataclass_fields__") else shown_value(value)


class ModifiedFlanksError(ValueError):
    """A calculation that does not take modified flanks into account."""


def require_unmodified(flank: str | None, subject: str, **members: Member) -> None:
    """Raise ModifiedFlanksError if a member has a modification.

    Parameters
    ----------
    flank : {'right', 'left'} or None
        Flank that is checked, None for both.
    subject : str
        The calculation, in the plural, for the message.
    **members : Member
        By name.
    """
    flanks = MODIFICATIONS if flank is None else (flank,)
    bad = [name for name, one in members.items() if any(one.modification(side) for side in flanks)]
    if bad:
        tables = " and ".join(f"[{name}.modification]" for name in bad)
        raise ModifiedFlanksError(f"{subject} do not support modified flanks yet: remove {tables}")
