"""Final layout of a page: separate overlapping labels; in print, set text sizes and place title, legends and
note.

Labels of several axes and fixed text are separated together, and print pages take their height from the
figure. Constrained layout of Matplotlib does neither, because pictures have fixed pixel positions, and
libraries such as adjustText only treat the labels of one pair of axes.
"""

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
from .layout import PAPER_INCHES_PER_INCH
from .theme import Page

FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]


def finish_page(page: Page) -> Page:
    """Finish a page: move labels apart, and in print set all other text.

    In print, text sizes are set, titles are broken into lines, tick labels without space are left out, title,
    subtitle and legends are placed above the figure and the note below, and empty space is cut off.
    """
    if page.layout.printed:
        for text in page.findobj(Text):
            _set_type(text)
        page.draw_without_rendering()  # creates the tick labels
        for axes in page.axes:
            _break_titles(axes)
            _fit_legend(axes.get_legend(), axes.get_window_extent().width)
            for axis in (axes.xaxis, axes.yaxis):
                _thin_out(axis)
        _surround(page)
    _part(page)
    return page


def visible_text(page: Page) -> list[tuple[Text, Bbox]]:
    """Return all visible text of a page with its bounding boxes, pixels."""
    page.draw_without_rendering()
    texts = [text for text in page.findobj(Text) if isinstance(text, Text) and text.get_visible()]
    hidden = {id(text) for axes in page.axes for text in _hidden(axes)}
    seen = [text for text in texts if text.get_text().strip() and id(text) not in hidden]
    return [(text, Text.get_window_extent(text)) for text in seen]


def _hidden(axes: Axes) -> list[Text]:
    """Return the text of axes that is not drawn: of hidden axes, and of ticks outside the limits."""
    if not axes.axison:
        return [text for axis in (axes.xaxis, axes.yaxis) for text in axis.findobj(Text)]
    hidden = []
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        tolerance = 1e-9 * (high - low)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
            if not low - tolerance <= tick.get_loc() <= high + tolerance or not tick.get_visible():
                hidden += [tick.label1, tick.label2]
        if not axis.get_visible():
            hidden += axis.findobj(Text)
    return hidden


def _set_type(text: Any) -> None:
    """Set the text size so that the text is legible in print."""
    # Points; an index is 0.7 times as large as the text.
    smallest, largest, with_index = 7.0, 9.0, 8.6
    words = text.get_text()
    least = with_index if "$" in words and ("_" in words or "^" in words) else smallest
    text.set_fontsize(
        float(np.clip(text.get_fontsize() * PAPER_INCHES_PER_INCH, least, largest)) / PAPER_INCHES_PER_INCH
    )


def _break_titles(axes: Axes) -> None:
    """Break titles and axis labels that are longer than their axes."""
    box = axes.get_window_extent()
    titles = [part for part in axes.get_children() if isinstance(part, Text) and part not in axes.texts]
    for text in (*titles, axes.xaxis.label):
        if text.get_text():
            theme.wrap_text(text, text.get_text(), box.width)
    label, words = axes.yaxis.label, axes.get_ylabel()
    if words and label.get_window_extent().height > box.height:
        rotation = label.get_rotation()
        label.set_rotation(0.0)
        theme.wrap_text(label, words, box.height)
        label.set_rotation(rotation)


def _fit_legend(legend: Legend | None, width: float) -> None:
    """Break the lines of a legend with one column, if the legend is wider than `width`, pixels."""
    over = legend.get_window_extent().width - width if legend else 0.0
    if legend and over > 0.0:
        longest = max(text.get_window_extent().width for text in legend.get_texts())
        for text in legend.get_texts():
            theme.wrap_text(text, text.get_text(), longest - over)


def _thin_out(axis: Axis) -> None:
    """Remove every second tick label while two labels are closer than 3 points."""
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
        if np.all(ends[1:, 0] - ends[:-1, 1] > 3.0 * axis.axes.figure.dpi / 72.0):
            return
        view = tuple(axis.get_view_interval())
        names = [tick.label1.get_text() or tick.label2.get_text() for tick in ticks]
        axis.set_ticks([tick.get_loc() for tick in ticks][::2], names[::2])
        axis.set_view_interval(view[0], view[1], ignore=True)


def _part(page: Page) -> None:
    """Move labels of points away from all other text and onto the page."""
    # Space between labels, and largest displacement of a label.
    apart_pt, farthest_pt, steps = 2.0, 60.0, 80
    labels = visible_text(page)
    boxes = np.array([box.get_points().ravel() for _, box in labels])
    free = np.array([_is_free(text) for text, _ in labels])
    if not free.any():
        return
    point, size = page.dpi / 72.0, np.array(page.canvas.get_width_height(), dtype=float)
    home = boxes.copy()
    for _ in range(steps):
        move = _pushes(boxes, free, 0.5 * apart_pt * point)
        beyond = np.maximum(-boxes[:, :2], 0.0) - np.maximum(boxes[:, 2:] - size, 0.0)
        move = np.where(free[:, None], move + beyond, 0.0)
        if not move.any():
            break
        away = np.clip(boxes[:, :2] + move - home[:, :2], -farthest_pt * point, farthest_pt * point)
        boxes = home + np.tile(away, 2)
    for (text, _), moved in zip(labels, (boxes - home)[:, :2] / point, strict=True):
        if moved.any():
            right, up = text.get_position()
            text.set_position((right + moved[0], up + moved[1]))


def _is_free(text: Text) -> bool:
    """Return True for a label of a point, which may be moved."""
    return isinstance(text, Annotation) and text.anncoords == "offset points"


def _pushes(boxes: FloatArray, free: BoolArray, space: float) -> FloatArray:
    """Return the displacements (n, 2), pixels, that separate movable boxes from all others.

    Parameters
    ----------
    boxes : ndarray, shape (n, 4)
        Left, bottom, right and top, pixels.
    free : ndarray of bool, shape (n,)
        Boxes that may be moved.
    space : float
        Space around each box, pixels.
    """
    low, high = boxes[:, :2] - space, boxes[:, 2:] + space
    over = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)  # (n, n, 2)
    touching = (over > 0.0).all(axis=-1) & (free[:, None] | free) & ~np.eye(len(boxes), dtype=bool)
    side = np.sign((low + high)[:, None] - (low + high))
    order = np.arange(len(boxes))
    first = np.sign(order[:, None] - order)[..., None]
    side = np.where(side == 0.0, first, side)  # of two boxes at the same height, the first moves down
    across = over[..., 0] < over[..., 1]
    share = np.where(free[:, None] & free, 0.5, 1.0)
    displacement = np.stack(
        (over[..., 0] * side[..., 0] * across, over[..., 1] * side[..., 1] * ~across), axis=-1
    )
    return np.asarray((displacement * (share * touching)[..., None]).sum(axis=1))


def _surround(page: Page) -> None:
    """Place title, subtitle and legends above the figure and the note below it, and set the page height."""
    # Margin of the page, and space between title, legends, figure and note.
    margin_in, space_in = 0.12, 0.16
    body = _body(page)
    dpi = page.dpi
    width = (page.layout.width - 2.0 * margin_in) * dpi
    over: list[Text | Legend] = []
    under: list[Text] = []
    if not page.layout.plain:
        bold: dict[str, Any] = {"fontsize": theme.TITLE, "fontweight": "bold"}
        quiet: dict[str, Any] = {"color": theme.GREY, "linespacing": 1.3}
        over = [
            _line(page, page.title, width, bold),
            _line(page, page.subtitle, width, {"fontsize": theme.LABEL, **quiet}),
        ]
        under = [_line(page, page.note, width, {"fontsize": theme.SMALL, **quiet})] if page.note else []
    for entries in page.legend_entries:
        over.append(_legend(page, entries, width))
    gap, edge = space_in * dpi, margin_in * dpi
    heights = {artist: artist.get_window_extent().height + gap for artist in (*over, *under)}
    bottom = round(edge + sum(heights[artist] for artist in under))
    top = bottom + (body.y1 - body.y0) + sum(heights[artist] for artist in over) + edge
    _resize(page, round(bottom - body.y0), float(np.ceil(top)))
    for artists, y in ((over, page.get_figheight() * dpi - edge), (under, bottom - gap)):
        for artist in artists:
            _move_to(page, artist, margin_in / page.layout.width, y)
            y -= heights[artist]


def _body(page: Page) -> Bbox:
    """Return the bounding box of everything on the page, pixels."""
    page.draw_without_rendering()
    boxes = [artist.get_tightbbox() for artist in (*page.axes, *page.texts)]
    return Bbox.union([box for box in boxes if box is not None and np.isfinite(box.extents).all()])


def _line(page: Page, words: str, width: float, style: dict[str, Any]) -> Text:
    """Write text over a width, pixels, at the top of the page; it is moved later."""
    text = page.text(0.0, 1.0, words, va="top", ha="left", **style)
    _set_type(text)
    theme.wrap_text(text, words, width)
    return text


def _legend(page: Page, entries: theme.Entries, width: float) -> Legend:
    """Return a legend with as many columns as fit into a width, pixels."""
    style = {"borderpad": 0.0, **entries.style, "loc": "upper left", "borderaxespad": 0.0}
    columns = min(entries.columns, len(entries.handles))
    while True:
        legend = page.legend(handles=entries.handles, ncols=columns, **style)
        for text in legend.findobj(Text):
            _set_type(text)
        if columns == 1 or legend.get_window_extent().width <= width:
            _fit_legend(legend, width)
            return legend
        legend.remove()
        columns -= 1


def _move_to(page: Page, artist: Any, x: float, y: float) -> None:
    """Move the upper left corner of text or a legend to x, a fraction of the width, and y, pixels."""
    place = x, y / (page.get_figheight() * page.dpi)
    if isinstance(artist, Text):
        artist.set_position(place)
    else:
        artist.set_bbox_to_anchor(place, page.transFigure)


def _resize(page: Page, shift: int, height: float) -> None:
    """Set the page height, pixels, and move everything on the page up by `shift` pixels."""
    before = page.get_figheight() * page.dpi
    places = [axes.get_position(original=True) for axes in page.axes]
    page.set_size_inches(page.layout.width, (height + 1e-6) / page.dpi)
    for axes, at in zip(page.axes, places, strict=True):
        axes.set_position((at.x0, (at.y0 * before + shift) / height, at.width, at.height * before / height))
    for text in page.texts:
        text.set_y((text.get_position()[1] * before + shift) / height)
