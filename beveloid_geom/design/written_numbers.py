"""Messages on numbers that are written otherwise: with a unit, a decimal comma, or outside a limit."""

from __future__ import annotations

import math
import re

import numpy as np

IN_RADIANS = "was it given in radians?"
MM_PER_INCH = 25.4
RAD_PER_DEGREE = math.pi / 180.0


def shown_value(value: object) -> str:
    """Return a value as one short line, in the notation of TOML."""
    if isinstance(value, bool | np.bool_):
        return str(value).lower()
    if isinstance(value, int) and value.bit_length() > 100:
        return f"an integer of {value.bit_length()} bits"
    if isinstance(value, np.ma.MaskedArray):
        return "a masked array"
    text = " ".join(repr(value.item() if isinstance(value, np.generic) else value).split())
    return text if len(text) <= 40 else text[:37] + "..."


def number_cure(text: str, unit: str = "") -> str | None:
    """Return the cure for a text with a decimal comma or a unit, instead of a number.

    Parameters
    ----------
    text : str
        Input text, such as '6,5' or '0.25 in'.
    unit : {'mm', 'um', 'deg', 'rad', ''}
        Unit in which the quantity is expected.

    Returns
    -------
    str or None
        Sentence with the number to give; None for any other text.
    """
    written_number = re.compile(r"\s*([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?)\s*([^\d\s.,;]*)\s*")
    match = written_number.fullmatch(text)
    if match is None:
        return None
    number, suffix = float(match[1].replace(",", ".")), match[2]
    if suffix:
        size = _conversions(unit).get(suffix.lower())
        return None if size is None else f"give it in {unit} without a unit, {number * size:.10g}"
    if "," not in match[1]:
        return None
    point, thousands = match[1].replace(",", "."), match[1].replace(",", "")
    # A comma before three digits may separate thousands.
    if re.fullmatch(r"[+-]?[1-9]\d{0,2},\d{3}", match[1]):
        return f"write it with a decimal point, {point}, or without the comma, {thousands}"
    return f"write it with a decimal point, {number:g}"


def _conversions(unit: str) -> dict[str, float]:
    """Return the factors to a unit by the unit in which a quantity was written."""
    lengths_mm = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "cm": 10.0, "m": 1e3}
    lengths_mm |= dict.fromkeys(("in", "inch", "inches", '"', "″"), MM_PER_INCH)
    angles_rad = {"rad": 1.0} | dict.fromkeys(("deg", "°", "degree", "degrees"), RAD_PER_DEGREE)
    angles_rad |= {"arcmin": RAD_PER_DEGREE / 60.0, "arcsec": RAD_PER_DEGREE / 3600.0}
    return {
        "mm": lengths_mm,
        "um": {name: size / 1e-3 for name, size in lengths_mm.items()},
        "rad": angles_rad,
        "deg": {name: size / RAD_PER_DEGREE for name, size in angles_rad.items()},
    }.get(unit, {})


def refused(limit: str, value: object, cure: str, place: str = "") -> str:
    """Return the message for a value outside its limit.

    Parameters
    ----------
    limit : str
        Such as 'be between 0 and 1 mm'.
    value : object
        The rejected value.
    cure : str
        Advice to the user.
    place : str
        Index in an array, such as ' at [3]'.
    """
    return f"must {limit}, got {shown_value(value)}{place}: {cure}"
