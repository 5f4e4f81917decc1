"""How inputs and results show themselves: a few lines, however long their arrays are, or a table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray


def few_lines(result: Any) -> str:
    """Give the `__repr__` of a dataclass of arrays: a line for each field, of an array its shape, least and
    greatest value and how many are NaN."""
    names = [field.name for field in fields(result) if field.repr]
    width = max(map(len, names), default=0)
    rows = [f"  {name:<{width}}  {_shown(getattr(result, name))}" for name in names]
    return "\n".join((type(result).__name__, *rows))


def html_table(shown: Any) -> str:
    """Give the `_repr_html_` of a dataclass, as notebooks ask for: its fields and those of its parts."""
    rows = (f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in _rows(shown))
    return f"<table><caption>{type(shown).__name__}, mm and rad</caption>{''.join(rows)}</table>"


def _rows(shown: Any, lead: str = "") -> Iterator[tuple[str, str]]:
    for field in fields(shown):
        value = getattr(shown, field.name)
        if field.repr and is_dataclass(value):
            yield from _rows(value, f"{lead}{field.name} ")
        elif field.repr:
            yield lead + field.name, _shown(value)


def _shown(value: object) -> str:
    if isinstance(value, np.ndarray):
        return _range(value) if value.ndim else str(value)
    if is_dataclass(value):
        return type(value).__name__
    if isinstance(value, (tuple, list, dict)) and len(value) > 4:
        return f"{type(value).__name__} of {len(value)}"
    text = ", ".join(map(_shown, value)) if isinstance(value, (tuple, list)) else repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _range(array: NDArray[Any]) -> str:
    """Say the shape, and what there is in it."""
    shape = f"[{' x '.join(map(str, array.shape))}]"
    if array.dtype.kind == "b":
        return f"{shape} {np.count_nonzero(array)} true"
    if array.dtype.kind not in "iuf" or not array.size:
        return f"{shape} {array.dtype}"
    known = array[~np.isnan(array)]
    if not known.size:
        return f"{shape} all NaN"
    lost = f", {array.size - known.size} NaN" if known.size < array.size else ""
    return f"{shape} {known.min():.6g} ... {known.max():.6g}{lost}"
