"""What is shared cannot be written to: results that are kept, and inputs, which compare by their values.

Whoever asks for a kept result gets the same arrays as the one before. They are made read-only, so
that writing to one raises instead of changing the results of others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache, wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np

if TYPE_CHECKING:
    from functools import _lru_cache_wrapper

T = TypeVar("T")
P = ParamSpec("P")


def read_only(value: T) -> T:
    """Give the value itself, with all arrays in it made read-only: also those in dataclasses, mappings, lists
    and tuples."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif is_dataclass(value) and not isinstance(value, type):
        read_only(vars(value))
    elif isinstance(value, Mapping):
        read_only(tuple(value.values()))
    elif isinstance(value, list | tuple):
        for part in value:
            read_only(part)
    return value


def equal(one: Any, other: object) -> bool:
    """Give the `__eq__` of a dataclass of numbers and arrays: the same class, and in every field the same
    values. Of arrays also the same shape. Inputs of plain numbers are hashable, those that hold arrays are
    not."""
    names = [part.name for part in fields(one)]
    if type(other) is not type(one):
        return NotImplemented  # type: ignore[no-any-return]
    pairs = [(getattr(one, name), getattr(other, name)) for name in names]
    return all(np.array_equal(a, b) if np.ndim(a) or np.ndim(b) else a == b for a, b in pairs)


def restored(made: object, state: dict[str, Any]) -> None:
    """Give the `__setstate__` of inputs and kept results: unpickled or copied, their arrays are read-only
    too."""
    vars(made).update(read_only(state))


def kept(most: int) -> Callable[[Callable[P, T]], _lru_cache_wrapper[T]]:
    """Decorate a function of hashable arguments so that its last results, `most` of them, are kept. Their
    arrays are read-only."""

    def decorate(function: Callable[P, T]) -> _lru_cache_wrapper[T]:
        """Make the function that keeps results."""

        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            return read_only(function(*args, **kwargs))

        return lru_cache(maxsize=most)(wraps(function)(call))

    return decorate
