"""The last steps of a page: words off each other; in print type of 7 to 9 points, what fits, words around."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, XAxis
from matplotlib.legend import Legend
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from . import theme
from .layout import SCALE
from .theme import Page

FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]
SMALLEST, LARGEST, WITH_INDEX = 7.0, 9.0, 8.6
"""Points of type in print, and the least where an index of 0.7 times its size would be under 6."""
EDGE, GAP = 0.12, 0.16
"""Inches around a page, and between what stands on it, one under another."""
APART, FARTHEST, STEPS = 2.0, 60.0, 80
"""Points between words beside places and other words, the farthest by which they are moved for it, and in how
many steps."""
CLEAR = 3.0
"""Points between labels of ticks."""


def settle(page: Page) -> Page:
    """Finish a page: move words beside places off others. In print first set its type, break titles, leave
    out labels of ticks that have no room, put title, subtitle and legends over the figure and the note
    under it, and cut off what is empty."""
    if page.layout.printed:
        for text in page.findobj(Text):
            _set_type(text)
        page.draw_without_rendering()  # or labels of ticks would not be known yet
        for axes in page.axes:
            _break_titles(axes)
            _fit_legend(axes)
            for axis in (axes.xaxis, axes.yaxis):
                _thin_out(axis)
        _surround(page)
    _part(page)
    return page


def written(page: Page) -> list[tuple[Text, Bbox]]:
    """Give all words that are seen on a page, with their boxes in pixels."""
    page.draw_without_rendering()
    texts = [text for text in page.findobj(Text) if isinstance(text, Text) and text.get_visible()]
    hidden = {id(text) for axes in page.axes for text in _hidden(axes)}
    seen = [text for text in texts if text.get_text().strip() and id(text) not in hidden]
    return [(text, Text.get_window_extent(text)) for text in seen]


def _hidden(axes: Axes) -> list[Text]:
    """Give the words of axes that are not drawn: of axes switched off, and of ticks outside the limits."""
    if not axes.axison:
        return [text for axis in (axes.xaxis, axes.yaxis) for text in axis.findobj(Text)]
    hidden = []
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        room = 1e-9 * (high - low)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            if not low - room <= tick.get_loc() <= high + room or not tick.get_visible():
                hidden += [tick.label1, tick.label2]
        if not axis.get_visible():
            hidden += axis.findobj(Text)
    return hidden


def _set_type(text: Any) -> None:
    """Set the size of type so that in print it is between SMALLEST and LARGEST."""
    words = text.get_text()
    least = WITH_INDEX if "$" in words and ("_" in words or "^" in words) else SMALLEST
    text.set_fontsize(float(np.clip(text.get_fontsize() * SCALE, least, LARGEST)) / SCALE)


def _break_titles(axes: Axes) -> None:
    """Break titles and names of axes that are longer than their axes."""
    box = axes.get_window_extent()
    titles = [part for part in axes.get_children() if isinstance(part, Text) and part not in axes.texts]
    for text in (*titles, axes.xaxis.label):
        if text.get_text():
            theme.fill(text, text.get_text(), box.width)
    label, words = axes.yaxis.label, axes.get_ylabel()
    if words and label.get_window_extent().height > box.height:
        rotation = label.get_rotation()
        label.set_rotation(0.0)
        theme.fill(label, words, box.height)
        label.set_rotation(rotation)


def _fit_legend(axes: Axes) -> None:
    """Break the words of a legend that is wider than its axes."""
    legend, width = axes.get_legend(), axes.get_window_extent().width
    over = legend.get_window_extent().width - width if legend else 0.0
    if legend and over > 0.0:
        longest = max(text.get_window_extent().width for text in legend.get_texts())
        for text in legend.get_texts():
            theme.fill(text, text.get_text(), longest - over)


def _thin_out(axis: Axis) -> None:
    """Leave out every other label of ticks while two are nearer than CLEAR."""
    along = 0 if isinstance(axis, XAxis) else 1
    for _ in range(4):
        low, high = sorted(axis.get_view_interval())
        ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
        labels = [label for tick in ticks for label in (tick.label1, tick.label2)]
        shown = [label for label in labels if label.get_visible() and label.get_text()]
        boxes = [label.get_window_extent() for label in shown]
        if len(boxes) < 3:
            return
        ends = np.sort(np.array([(box.min[along], box.max[along]) for box in boxes]), axis=0)
        if np.all(ends[1:, 0] - ends[:-1, 1] > CLEAR * axis.axes.figure.dpi / 72.0):
            return
        view = tuple(axis.get_view_interval())
        names = [tick.label1.get_text() or tick.label2.get_text() for tick in ticks]
        axis.set_ticks([tick.get_loc() for tick in ticks][::2], names[::2])
        axis.set_view_interval(view[0], view[1], ignore=True)


def _part(page: Page) -> None:
    """Move words that stand beside a place off all other words and onto the page, by FARTHEST at most."""
    found = written(page)
    boxes = np.array([box.get_points().ravel() for _, box in found])
    free = np.array([_is_free(text) for text, _ in found])
    if not free.any():
        return
    point, size = page.dpi / 72.0, np.array(page.canvas.get_width_height(), dtype=float)
    home = boxes.copy()
    for _ in range(STEPS):
        move = _pushes(boxes, free, 0.5 * APART * point)
        beyond = np.maximum(-boxes[:, :2], 0.0) - np.maximum(boxes[:, 2:] - size, 0.0)
        move = np.where(free[:, None], move + beyond, 0.0)
        if not move.any():
            break
        away = np.clip(boxes[:, :2] + move - home[:, :2], -FARTHEST * point, FARTHEST * point)
        boxes = home + np.tile(away, 2)
    for (text, _), moved in zip(found, (boxes - home)[:, :2] / point, strict=True):
        if moved.any():
            right, up = text.get_position()
            text.set_position((right + moved[0], up + moved[1]))


def _is_free(text: Text) -> bool:
    """Say whether words stand beside a place, by points of the page."""
    return isinstance(text, Annotation) and text.anncoords == "offset points"


def _pushes(boxes: FloatArray, free: BoolArray, room: float) -> FloatArray:
    """Give for boxes (n, 4), pixels, the way (n, 2) that takes those that are free off others, with so much
    room on each side: the shorter one, shared by two that are both free."""
    low, high = boxes[:, :2] - room, boxes[:, 2:] + room
    over = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)  # (n, n, 2)
    touching = (over > 0.0).all(axis=-1) & (free[:, None] | free) & ~np.eye(len(boxes), dtype=bool)
    side = np.sign((low + high)[:, None] - (low + high))
    order = np.arange(len(boxes))
    first = np.sign(order[:, None] - order)[..., None]
    side = np.where(side == 0.0, first, side)  # of two at the same height the first gives way downwards
    across = over[..., 0] < over[..., 1]
    share = np.where(free[:, None] & free, 0.5, 1.0)
    way = np.stack((over[..., 0] * side[..., 0] * across, over[..., 1] * side[..., 1] * ~across), axis=-1)
    return np.asarray((way * (share * touching)[..., None]).sum(axis=1))


def _surround(page: Page) -> None:
    """Make the page as high as its figure and the words around it: title, subtitle, legends, figure, note."""
    body = _body(page)
    width, dpi = page.layout.width - 2.0 * EDGE, page.dpi
    over: list[Text | Legend] = []
    under: list[Text] = []
    if not page.layout.plain:
        bold: dict[str, Any] = {"fontsize": theme.TITLE, "fontweight": "bold"}
        quiet: dict[str, Any] = {"color": theme.GREY, "linespacing": 1.3}
        over = [_line(page, page.title, bold), _line(page, page.subtitle, {"fontsize": theme.LABEL, **quiet})]
        under = [_line(page, page.note, {"fontsize": theme.SMALL, **quiet})] if page.note else []
    for entries in page.legend_entries:
        over.append(_legend(page, entries, width * dpi))
    heights = (
        [artist.get_window_extent().height for artist in over],
        [a.get_window_extent().height for a in under],
    )
    gap, edge = GAP * dpi, EDGE * dpi
    bottom = round(edge + sum(height + gap for height in heights[1]))
    top = bottom + (body.y1 - body.y0) + sum(height + gap for height in heights[0]) + edge
    _resize(page, round(bottom - body.y0), float(np.ceil(top)))
    y = page.get_figheight() * dpi - edge
    for artist, height in zip(over, heights[0], strict=True):
        _stand(page, artist, EDGE / page.layout.width, y)
        y -= height + gap
    y = bottom - gap
    for artist, height in zip(under, heights[1], strict=True):
        _stand(page, artist, EDGE / page.layout.width, y)
        y -= height + gap


def _body(page: Page) -> Bbox:
    """Give the box, pixels, of all that is on the page."""
    page.draw_without_rendering()
    boxes = [artist.get_tightbbox() for artist in (*page.axes, *page.texts)]
    return Bbox.union([box for box in boxes if box is not None and np.isfinite(box.extents).all()])


def _line(page: Page, words: str, style: dict[str, Any]) -> Text:
    """Write words as wide as the page, at the top of it for now."""
    text = page.text(0.0, 1.0, words, va="top", ha="left", **style)
    _set_type(text)
    theme.fill(text, words, (page.layout.width - 2.0 * EDGE) * page.dpi)
    return text


def _legend(page: Page, entries: theme.Entries, width: float) -> Legend:
    """Make a legend of as many columns as have room in a width, pixels."""
    style = {"borderpad": 0.0, **entries.style, "loc": "upper left", "borderaxespad": 0.0}
    columns = min(entries.columns, len(entries.handles))
    while True:
        legend = page.legend(handles=entries.handles, ncols=columns, **style)
        for text in legend.findobj(Text):
            _set_type(text)
        if columns == 1 or legend.get_window_extent().width <= width:
            return legend
        legend.remove()
        columns -= 1


def _stand(page: Page, artist: Any, x: float, y: float) -> None:
    """Put the upper left corner of words or a legend at a share of the width and a height in pixels."""
    place = x, y / (page.get_figheight() * page.dpi)
    if isinstance(artist, Text):
        artist.set_position(place)
    else:
        artist.set_bbox_to_anchor(place, page.transFigure)


def _resize(page: Page, shift: int, height: float) -> None:
    """Make a page so many pixels high, and move all that is on it up by `shift` pixels."""
    before = page.get_figheight() * page.dpi
    places = [axes.get_position(original=True) for axes in page.axes]
    page.set_size_inches(page.layout.width, (height + 1e-6) / page.dpi)
    for axes, at in zip(page.axes, places, strict=True):
        axes.set_position((at.x0, (at.y0 * before + shift) / height, at.width, at.height * before / height))
    for text in page.texts:
        text.set_y((text.get_position()[1] * before + shift) / height)
