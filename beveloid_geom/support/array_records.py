"""Dataclasses whose fields are arrays with a common axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import T


def joined(parts: Sequence[T], axis: int = -1) -> T:
    """Return several records as one, with all their arrays concatenated.

    Parameters
    ----------
    parts : sequence of dataclass
        At least one record; all have the same class.
    axis : int
        Axis along which arrays are concatenated.

    Returns
    -------
    dataclass
        A record of the same class.
    """
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    return type(parts[0])(*(np.concatenate(column, axis=axis) for column in columns))
