"""Types and names that all packages share."""

from __future__ import annotations

from typing import Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]
Codes: TypeAlias = NDArray[np.int8]
"""Codes of an enum of `status`."""
Integers: TypeAlias = NDArray[np.int_]
Indices: TypeAlias = NDArray[np.int64]
Quantity: TypeAlias = float | FloatArray
Flank: TypeAlias = Literal["right", "left"]
T = TypeVar("T")

COMPLEX_STEP = 1e-30
"""Imaginary step of an exact derivative; its square is lost in rounding."""
MEMBERS = ("pinion", "gear")
FLANKS = ("right", "left")
FLANK_SIGN: dict[str, float] = {"right": 1.0, "left": -1.0}


def flank_sign(flank: str) -> float:
    """+1 for the right flank (upper sign of Eq. 4), -1 for the left one."""
    try:
        return FLANK_SIGN[flank]
    except KeyError:
        raise ValueError(f"flank must be 'right' or 'left', got {flank!r}") from None


def gear_sense(flank: str) -> float:
    """Return the sense of the gear's roll while the pinion drives on a flank.

    The pinion's roll rises on right flanks and falls on left flanks; the gear turns in the opposite sense.
    An angle of the gear, multiplied by this sense, is positive if the gear is ahead.

    Parameters
    ----------
    flank : {'right', 'left'}

    Returns
    -------
    float
        -1 on right flanks, +1 on left flanks.

    Raises
    ------
    ValueError
        For another name of a flank.
    """
    return -flank_sign(flank)
