"""Floor plans in all formats: two rooms of 4 m × 3 m each, with a door of 1 m between them."""

import io

import ezdxf
from PIL import Image, ImageDraw

PIXEL = 0.02
"""Edge of a pixel of the picture [m]."""

WALLS = (
    ((1.0, 1.0), (9.0, 1.0)), ((9.0, 1.0), (9.0, 4.0)), ((9.0, 4.0), (1.0, 4.0)), ((1.0, 4.0), (1.0, 1.0)),
    ((5.0, 1.0), (5.0, 2.0)), ((5.0, 3.0), (5.0, 4.0)),
)  # fmt: skip
"""Walls, x to the right and y down [m]."""


def picture_plan(kind: str = "PNG") -> bytes:
    """Return the plan as picture, or as a page of a PDF that has it."""
    picture = Image.new("RGB", (500, 250), "white")
    brush = ImageDraw.Draw(picture)
    for begin, end in WALLS:
        brush.line([(x / PIXEL, y / PIXEL) for x, y in (begin, end)], "black", 5)
    file = io.BytesIO()
    picture.save(file, kind)
    return file.getvalue()


def svg_plan(extra: str = "", size: str = 'viewBox="0 0 1000 500" width="100mm" height="50mm"') -> bytes:
    """Return the plan as SVG with units of 1 cm, with a door, a text and furniture."""
    lines = "".join(f'<path d="M{100 * a} {100 * b}L{100 * c} {100 * d}"/>' for (a, b), (c, d) in WALLS)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}><g stroke="#222" stroke-width="3mm" fill="none">{lines}</g>'
        '<g id="Doors"><path d="M500 200V300" stroke="black"/></g><text x="200" y="200" font-size="60">room</text>'
        f'<rect class="furniture" x="200" y="200" width="60" height="60"/>{extra}</svg>'
    ).encode()


def dxf_plan(*, unit: int = 4, binary: bool = False) -> bytes:
    """Return the plan as DXF with millimetres, y up; its column is a block, and its door a block with a layer."""
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = unit
    space = document.modelspace()
    for name in ("A-WALL", "A-DOOR", "A-ANNO-DIMS"):
        document.layers.add(name)
    for (a, b), (c, d) in WALLS:
        space.add_line((1000 * a, 5000 - 1000 * b), (1000 * c, 5000 - 1000 * d), dxfattribs={"layer": "A-WALL"})
    column = document.blocks.new("COLUMN")
    column.add_circle((0, 0), 200)
    space.add_blockref("COLUMN", (3000, 2500), dxfattribs={"layer": "A-WALL"})
    space.add_line((5000, 2000), (5000, 3000), dxfattribs={"layer": "A-DOOR"})
    space.add_arc((5000, 2000), 1000, 0, 90, dxfattribs={"layer": "A-DOOR"})
    space.add_line((0, 0), (10_000, 0), dxfattribs={"layer": "A-ANNO-DIMS"})
    space.add_text("room", dxfattribs={"layer": "A-WALL"})
    if binary:
        file = io.BytesIO()
        document.write(file, fmt="bin")
        return file.getvalue()
    text = io.StringIO()
    document.write(text)
    return text.getvalue().encode()
