"""Floor plans as a page of a PDF, rendered by PDFium."""

from typing import Any

import numpy as np

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.drawings.plan_picture import DrawnPlan, PlanOptions, pixels_of
from ppaas.imports.report import ImportReport

MOST_OBJECTS = 500_000


def draw_pdf(content: bytes, options: PlanOptions, report: ImportReport) -> DrawnPlan:
    """Return a page as plan; points of its scale are in points of 1/72 inch.

    Raises
    ------
    InvalidMap
        It is no PDF, is encrypted, has no such page, or would be too large.
    InvalidInput
        PDFium is not installed.
    """
    try:
        import pypdfium2  # noqa: PLC0415 - needed for these files alone
    except ImportError as error:
        raise InvalidInput(f"plans as PDF need PDFium: {install_hint('drawings')}") from error
    try:
        document = pypdfium2.PdfDocument(content)
    except pypdfium2.PdfiumError as error:
        raise InvalidMap(f"the PDF cannot be read: {error}") from error
    try:
        return _drawn(document, options, report)
    except pypdfium2.PdfiumError as error:
        raise InvalidMap(f"page {options.page} of the PDF cannot be read: {error}") from error
    finally:
        document.close()


def _drawn(document: Any, options: PlanOptions, report: ImportReport) -> DrawnPlan:
    if not 1 <= options.page <= len(document):
        raise InvalidMap(f"the PDF has {len(document)} pages, and no page {options.page}")
    page = document[options.page - 1]
    width, height = page.get_size()
    texts = _without_texts(page)
    columns, rows, pixel = pixels_of(width, height, options)
    # PDFium rounds the size up: the last row and column may be beyond the page.
    greys = page.render(scale=max(columns / width, rows / height), grayscale=True).to_numpy()
    report.taken(f"page {options.page} of {len(document)}", f"{width:g} × {height:g} points")
    if texts:
        report.without_effect("texts", f"{texts}: text is no wall")
    return DrawnPlan(np.array(greys.reshape(greys.shape[0], greys.shape[1])), pixel)


def _without_texts(page: Any) -> int:
    from pypdfium2 import raw  # noqa: PLC0415 - needed for these files alone

    found = []
    for number, each in enumerate(page.get_objects()):
        if number > MOST_OBJECTS:
            raise InvalidMap(f"the page has more than {MOST_OBJECTS} objects: render it as a picture first")
        if each.type == raw.FPDF_PAGEOBJ_TEXT and each.container is None:
            found.append(each)
    for each in found:
        page.remove_obj(each)
    if found:
        page.gen_content()
    return len(found)
