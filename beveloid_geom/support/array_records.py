"""Dataclasses whose fields are arrays with a common axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

T = TypeVar("T")


def joined(parts: Sequence[T], axis: int = -1) -> T:
    """Return several records of one class as one, with all their arrays concatenated along an axis."""
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    return type(parts[0])(*(np.concatenate(column, axis=axis) for column in columns))
