"""Read-only arrays in inputs and in cached results, and comparison of inputs by value.

All callers of a cached function get the same arrays. These are read-only, so that an assignment raises an
exception and does not change the results of other callers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, wraps
from typing import TYPE_CHECKING, Any, ParamSpec

import numpy as np

from ..arrays import T

if TYPE_CHECKING:
    from functools import _lru_cache_wrapper

P = ParamSpec("P")


def read_only(value: T) -> T:
    """Return `value` itself, after making all arrays in it read-only.

    Arrays in dataclasses, mappings, lists and tuples are included."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif hasattr(type(value), "__dataclass_fields__"):
        read_only(tuple(vars(value).values()))
    elif isinstance(value, list | tuple):
        for part in value:
            read_only(part)
    elif isinstance(value, Mapping):
        read_only(tuple(value.values()))
    return value


def equal(one: Any, other: object) -> bool:
    """Return whether two dataclasses of numbers and arrays are equal; for use as `__eq__`.

    They are equal if they have the same class and equal values, and for arrays the same shape, in every
    field. Inputs of numbers are hashable, those with arrays are not."""
    if type(other) is not type(one):
        return NotImplemented  # type: ignore[no-any-return]
    for name in vars(type(one))["__dataclass_fields__"]:
        a, b = getattr(one, name), getattr(other, name)
        if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
            if not np.array_equal(a, b):
                return False
        elif a is not b and a != b:  # parts that two designs share need no comparison
            return False
    return True


def restored(made: object, state: dict[str, Any]) -> None:
    """Set the state of an unpickled or copied object, with read-only arrays; for use as `__setstate__`."""
    vars(made).update(read_only(state))


def cached(most: int) -> Callable[[Callable[P, T]], _lru_cache_wrapper[T]]:
    """Return a decorator that caches the last results of a function of hashable arguments.

    Parameters
    ----------
    most : int
        Number of results in the cache. Their arrays are read-only.
    """

    def decorate(function: Callable[P, T]) -> _lru_cache_wrapper[T]:
        """Return the function with a cache."""

        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            return read_only(function(*args, **kwargs))

        return lru_cache(maxsize=most)(wraps(function)(call))

    return decorate
