"""Dataclasses whose fields are arrays with a common axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import T


def joined(parts: Sequence[T], axis: int = -1) -> T:
    """Return several records of one class as one, with all their arrays concatenated along an axis."""
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    return type(parts[0])(*(np.concatenate(column, axis=axis) for column in columns))
