"""Pages as files: PNG with its true density, PDF and SVG of their true size, with type and lines as such."""

from __future__ import annotations

import io
import re
from typing import Any

from matplotlib.backends.backend_mixed import MixedModeRenderer
from matplotlib.backends.backend_pdf import Op, PdfFile, RendererPdf

from .theme import Page

FORMATS = ("png", "pdf", "svg")


def file_of(page: Page, form: str) -> bytes:
    """Give a page as a file of one of FORMATS."""
    file = io.BytesIO()
    if form == "pdf":
        _write_pdf(page, file)
        return file.getvalue()
    if form == "svg":
        page.savefig(file, format="svg", dpi=page.dpi, metadata={"Date": None})
        return _scaled(file.getvalue(), page.layout.scale)
    density = page.dpi / page.layout.scale
    page.savefig(
        file, format="png", dpi=page.dpi, metadata={"Software": None}, pil_kwargs={"dpi": 2 * (density,)}
    )
    return file.getvalue()


def _scaled(svg: bytes, scale: float) -> bytes:
    """Give an SVG picture another size; its coordinates stay."""

    def resized(found: re.Match[bytes]) -> bytes:
        width, height = (scale * float(size) for size in found.groups())
        return f'width="{width:.4f}pt" height="{height:.4f}pt"'.encode()

    return re.sub(rb'width="([\d.]+)pt" height="([\d.]+)pt"', resized, svg, count=1)


def _write_pdf(page: Page, file: io.BytesIO) -> None:
    """Write a page as PDF, drawn in points of the layout under one matrix that scales it."""
    scale, dpi = page.layout.scale, page.dpi
    width, height = page.get_size_inches()
    file_of_pdf: Any = PdfFile  # Matplotlib gives no types for these
    in_pdf: Any = RendererPdf
    mixed: Any = MixedModeRenderer
    pdf = file_of_pdf(file, metadata={"CreationDate": None})
    pdf.newPage(scale * width, scale * height)
    pdf.width, pdf.height = width, height  # to which lines are clipped, under the matrix
    pdf.output(scale, 0, 0, scale, 0, 0, Op.concat_matrix)
    renderer = mixed(page, width, height, dpi, in_pdf(pdf, dpi, height, width))
    page.dpi = 72.0  # points to an inch, as in PDF
    page.draw(renderer)
    page.dpi = dpi
    renderer.finalize()
    pdf.finalize()
    pdf.close()
