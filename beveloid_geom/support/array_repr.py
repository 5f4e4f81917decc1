"""Short text and HTML of dataclasses of arrays, independent of the size of the arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..status import CODES_OF_FIELDS


def short_repr(result: Any) -> str:
    """Return the `__repr__` of a dataclass of arrays, with one line for each field.

    The line of an array shows its shape, its smallest and largest value and the number of NaN; the line of
    codes shows their names."""
    names = [field.name for field in fields(result) if field.repr]
    width = max(map(len, names), default=0)
    rows = [f"  {name:<{width}}  {_field_text(result, name)}" for name in names]
    return "\n".join((type(result).__name__, *rows))


def call_repr(inputs: Any) -> str:
    """Return the `__repr__` of an input: the call that creates it, without values equal to their default.

    Arrays are shown by their shape and range."""
    words = []
    for field in fields(inputs):
        value = getattr(inputs, field.name)
        default = field.default if field.default_factory is MISSING else field.default_factory()
        if np.ndim(value) or value != default:
            text = repr(value) if vars(type(value)).get("__repr__") is call_repr else _text(value)
            words.append(f"{field.name}={text}")
    return f"{type(inputs).__name__}({', '.join(words)})"


def html_table(result: Any) -> str:
    """Return the `_repr_html_` of a dataclass for notebooks: a table of its fields and those of its parts."""
    rows = (f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in _rows(result))
    return f"<table><caption>{type(result).__name__}, mm and rad</caption>{''.join(rows)}</table>"


def _rows(result: Any, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield name and text of each field that is not None, also of dataclasses in fields."""
    for field in fields(result):
        value = getattr(result, field.name)
        if field.repr and is_dataclass(value):
            yield from _rows(value, f"{prefix}{field.name} ")
        elif field.repr and value is not None:
            yield prefix + field.name, _field_text(result, field.name)


def _field_text(result: Any, name: str) -> str:
    """Return the text of a field, with the names of codes in place of their numbers."""
    value, codes = getattr(result, name), CODES_OF_FIELDS.get(f"{type(result).__name__}.{name}")
    if codes is None or value is None:
        return _text(value)
    array = np.asarray(value)
    names = {int(code): code.name.lower() for code in codes}
    occurring, counts = np.unique(array, return_counts=True)
    words = [names.get(code, "none") for code in occurring.tolist()]
    if len(words) > 1:
        # Small arrays show the code of each position, large ones how often each code occurs.
        listed = array.size <= 4
        each = (names.get(code, "none") for code in array.ravel().tolist())
        words = list(each) if listed else [f"{word} {n}" for word, n in zip(words, counts, strict=True)]
    text = ", ".join(words[:4]) + (", ..." if len(words) > 4 else "")
    return f"[{' x '.join(map(str, array.shape))}] {text}" if array.ndim else text


def _text(value: object) -> str:
    """Return the text of a field; long texts and collections are shortened."""
    if isinstance(value, np.ndarray):
        return _range(value) if value.ndim else str(value)
    if is_dataclass(value):
        return type(value).__name__
    if isinstance(value, (tuple, list, dict)) and len(value) > 4:
        return f"{type(value).__name__} of {len(value)}"
    text = ", ".join(map(_text, value)) or "none" if isinstance(value, (tuple, list)) else repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _range(array: NDArray[Any]) -> str:
    """Return the shape and the range of an array."""
    shape = f"[{' x '.join(map(str, array.shape))}]"
    if array.dtype.kind == "b":
        return f"{shape} {np.count_nonzero(array)} true"
    if array.dtype.kind not in "iuf" or not array.size:
        return f"{shape} {array.dtype}"
    numbers = array[~np.isnan(array)]
    if not numbers.size:
        return f"{shape} all NaN"
    missing = f", {array.size - numbers.size} NaN" if numbers.size < array.size else ""
    return f"{shape} {numbers.min():.6g} ... {numbers.max():.6g}{missing}"
