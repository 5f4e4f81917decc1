"""Write pages as PNG with the correct resolution, and as PDF and SVG of the correct size."""

from __future__ import annotations

import io
import re
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_mixed import MixedModeRenderer
from matplotlib.backends.backend_pdf import Op, PdfFile, RendererPdf
from PIL import Image

from .theme import Page


def file_of(page: Page, form: str) -> bytes:
    """Return a page as the content of a file.

    Parameters
    ----------
    page : Page
        Page to write.
    form : {'png', 'pdf', 'svg'}
        File format.

    Returns
    -------
    bytes
        Content of the file.
    """
    file = io.BytesIO()
    if form == "pdf":
        _write_pdf(page, file)
        return file.getvalue()
    if form == "svg":
        with matplotlib.rc_context({"svg.fonttype": "none"}):  # text instead of outlines of its letters
            page.savefig(file, format="svg", dpi=page.dpi, metadata={"Date": None})
        return _scaled(file.getvalue(), page.layout.scale)
    canvas: Any = page.canvas
    canvas.draw()
    image = Image.fromarray(np.array(canvas.buffer_rgba())[..., :3])  # pages are opaque: no alpha channel
    image.save(file, "PNG", dpi=2 * (page.dpi / page.layout.scale,))
    return file.getvalue()


def _scaled(svg: bytes, scale: float) -> bytes:
    """Return an SVG picture at another size; coordinates stay as they are."""

    def resized(matched: re.Match[bytes]) -> bytes:
        width, height = (scale * float(size) for size in matched.groups())
        return f'width="{width:.4f}pt" height="{height:.4f}pt"'.encode()

    return re.sub(rb'width="([\d.]+)pt" height="([\d.]+)pt"', resized, svg, count=1)


def _write_pdf(page: Page, file: io.BytesIO) -> None:
    """Write a page as PDF in points of the layout, with one matrix that scales all drawing commands."""
    scale, dpi = page.layout.scale, page.dpi
    width, height = page.get_size_inches()
    file_of_pdf: Any = PdfFile  # Matplotlib has no type hints for these attributes
    in_pdf: Any = RendererPdf
    mixed: Any = MixedModeRenderer
    pdf = file_of_pdf(file, metadata={"CreationDate": None})
    pdf.newPage(scale * width, scale * height)
    pdf.width, pdf.height = width, height  # lines are clipped to this size before the matrix is applied
    pdf.output(scale, 0, 0, scale, 0, 0, Op.concat_matrix)
    renderer = mixed(page, width, height, dpi, in_pdf(pdf, dpi, height, width))
    page.dpi = 72.0  # points per inch, as in PDF
    page.draw(renderer)
    page.dpi = dpi
    renderer.finalize()
    pdf.finalize()
    pdf.close()
