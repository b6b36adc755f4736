"""Floor plans as SVG, rendered by resvg. Text is no wall, and doors are open."""

import io
import re
from typing import TYPE_CHECKING

import numpy as np
from PIL.PngImagePlugin import PngImageFile

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.maps.drawings.names import is_door, is_other
from ppaas.imports.maps.drawings.plan_picture import DrawnPlan, PlanOptions, pixels_of
from ppaas.imports.report import ImportReport

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MOST_ELEMENTS = 200_000

_LENGTH = re.compile(r"\s*([0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(px|pt|pc|mm|cm|in|Q)?\s*")
_UNITS = {"px": 1.0, "pt": 4 / 3, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "Q": 96 / 101.6}
"""Pixels of a unit (CSS)."""

_TEXTS = ("text", "tspan", "flowRoot", "title", "desc")
_NAMES = ("id", "class", "label", "data-name")
_NAMESPACE = "http://www.w3.org/2000/svg"


def draw_svg(content: bytes, options: PlanOptions, report: ImportReport) -> DrawnPlan:
    """Return an SVG as plan; points of its scale are in the units of its view box.

    Raises
    ------
    InvalidMap
        It is not SVG, has no size, or would be too large.
    InvalidInput
        resvg is not installed.
    """
    try:
        import resvg_py  # noqa: PLC0415 - needed for these files alone
    except ImportError as error:
        raise InvalidInput(f"plans as SVG need resvg: {install_hint('drawings')}") from error
    from xml.etree import ElementTree  # noqa: PLC0415 - writes what the safe parser read

    root = _parsed(content)
    width, height = _size(root)
    _strip(root, report)
    columns, rows, pixel = pixels_of(width, height, options)
    root.set("width", str(columns))
    root.set("height", str(rows))
    root.set("preserveAspectRatio", "none")
    ElementTree.register_namespace("", _NAMESPACE)
    try:
        # resvg would stop at ``width`` alone if the ratios differ.
        png = resvg_py.svg_to_bytes(
            svg_string=ElementTree.tostring(root, "unicode"), background="white", skip_system_fonts=True, dpi=96.0
        )
    except ValueError as error:
        raise InvalidMap(f"the SVG cannot be drawn: {error}") from error
    report.taken("drawing", f"{width:g} × {height:g} units")
    return DrawnPlan(np.asarray(PngImageFile(io.BytesIO(png)).convert("L")), pixel)


def _parsed(content: bytes) -> "Element":
    from defusedxml import DefusedXmlException  # noqa: PLC0415 - needed for these files alone
    from defusedxml.ElementTree import ParseError, fromstring  # noqa: PLC0415

    try:
        root: Element = fromstring(content)
    except (ParseError, DefusedXmlException, ValueError) as error:
        raise InvalidMap(f"the SVG is not valid XML: {error}") from error
    if root.tag.rpartition("}")[2] != "svg":
        raise InvalidMap(f"the file is not SVG: its root is {root.tag.rpartition('}')[2]!r}")
    if sum(1 for _ in root.iter()) > MOST_ELEMENTS:
        raise InvalidMap(f"the SVG has more than {MOST_ELEMENTS} elements")
    return root


def _size(root: "Element") -> tuple[float, float]:
    """Return the size of the view box; one is added if the file has none."""
    box = re.split(r"[\s,]+", root.get("viewBox", "").strip())
    if len(box) == 4:
        try:
            width, height = float(box[2]), float(box[3])
        except ValueError as error:
            raise InvalidMap(f"the view box of the SVG is not valid: {root.get('viewBox')!r}") from error
    else:
        width, height = _pixels(root.get("width")), _pixels(root.get("height"))
        root.set("viewBox", f"0 0 {width} {height}")
    if not (0.0 < width < 1e7 and 0.0 < height < 1e7):
        raise InvalidMap("the SVG has no size: set its width and height, or its view box")
    return width, height


def _pixels(text: str | None) -> float:
    found = _LENGTH.fullmatch(text or "")
    return float(found[1]) * _UNITS[found[2] or "px"] if found else 0.0


def _strip(root: "Element", report: ImportReport) -> None:
    """Take doors, texts and what else is no wall out of a drawing, by their names."""
    counts = {"doors": 0, "texts": 0, "others": 0}
    for parent in list(root.iter()):
        for child in list(parent):
            tag = child.tag.rpartition("}")[2] if isinstance(child.tag, str) else "comment"
            kind = "texts" if tag in _TEXTS else _kind(" ".join(
                [value for key, value in child.attrib.items() if key.rpartition("}")[2] in _NAMES]
            ))  # fmt: skip
            if kind is not None:
                counts[kind] += 1
                parent.remove(child)
    if counts["doors"]:
        report.translated("doors", f"{counts['doors']} elements named as doors are open")
    if counts["texts"]:
        report.without_effect("texts", f"{counts['texts']}: text is no wall")
    if counts["others"]:
        report.without_effect("others", f"{counts['others']} elements named as dimensions, furniture or notes")


def _kind(words: str) -> str | None:
    """Return what an element is by its names; None for a wall."""
    if not words:
        return None
    return "doors" if is_door(words) else "others" if is_other(words) else None
