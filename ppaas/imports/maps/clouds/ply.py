"""PLY files: ascii, and binary of both byte orders. Only the vertices are read.

Source: the description of the format by Greg Turk (Stanford).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.imports.maps.clouds.number_text import number_table
from ppaas.imports.maps.clouds.point_cloud import PointCloud, check_count, check_size, cloud_of
from ppaas.imports.report import ImportReport

MAX_HEADER = 1 << 16
"""Limit of the size of a header [bytes]."""

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_AXES = ("x", "y", "z")


@dataclass(slots=True)
class _Element:
    name: str
    count: int
    properties: list[tuple[str, str]] = field(default_factory=list)
    has_lists: bool = False


def read_ply(content: bytes, report: ImportReport) -> PointCloud:
    """Read the vertices of a PLY file.

    Raises
    ------
    InvalidMap
        It is no PLY file, it is truncated, or it has too many vertices.
    """
    try:
        order, elements, body = _header(content)
    except (ValueError, IndexError, KeyError) as error:
        raise InvalidMap(f"the header of the PLY is not valid: {error}") from error
    before, vertices = [], None
    for element in elements:
        if element.name == "vertex":
            vertices = element
            break
        before.append(element)
    if vertices is None or not set(_AXES) <= {name for name, _ in vertices.properties}:
        raise InvalidMap("the PLY has no vertices with x, y and z")
    check_count(vertices.count, "PLY")
    if vertices.has_lists or any(element.has_lists for element in before):
        raise InvalidMap("the PLY has lists in or before its vertices: save it with plain vertices first")
    others = [name for name, _ in vertices.properties if name not in _AXES]
    if others:
        report.without_effect("properties", f"{', '.join(others)}: a map has places alone")
    for element in elements:
        if element.name != "vertex" and element.count:
            reason = "only vertices become obstacles: sample the surfaces of a mesh as points first"
            report.without_effect(f"element {element.name}", f"{element.count}: {reason}")
    if order:
        return cloud_of(_binary(content, body, before, vertices, order), report)
    return cloud_of(_ascii(content, body, before, vertices), report)


def _header(content: bytes) -> tuple[str, list[_Element], int]:
    """Return the byte order, the elements and where the body begins."""
    end = content.find(b"end_header", 0, MAX_HEADER)
    if not content.startswith(b"ply") or end < 0:
        raise ValueError("it must begin with 'ply' and end with 'end_header'")
    after = content[end + 10 : end + 12]
    body = end + 10 + (2 if after == b"\r\n" else 1)
    order, elements = "", list[_Element]()
    for line in content[:end].decode("ascii", "replace").splitlines()[1:]:
        match line.split():
            case ["format", name, _]:
                order = _ORDERS[name]
            case ["element", name, count]:
                elements.append(_Element(name, int(count)))
            case ["property", "list", *_]:
                elements[-1].has_lists = True
            case ["property", kind, name]:
                elements[-1].properties.append((name, _TYPES[kind]))
            case _:
                pass  # comments
    if any(element.count < 0 for element in elements):
        raise ValueError("an element has a negative count")
    return order, elements, body


_Columns = tuple[NDArray[np.generic], NDArray[np.generic], NDArray[np.generic]]


def _binary(content: bytes, body: int, before: list[_Element], vertices: _Element, order: str) -> _Columns:
    begin = body + sum(element.count * sum(int(kind[1]) for _, kind in element.properties) for element in before)
    fields = [f"f{number}" for number in range(len(vertices.properties))]
    form = np.dtype([(each, order + kind) for each, (_, kind) in zip(fields, vertices.properties, strict=True)])
    check_size(vertices.count * form.itemsize, len(content) - begin, "PLY")
    table = np.frombuffer(content, form, vertices.count, begin)
    names = [name for name, _ in vertices.properties]
    x, y, z = (table[fields[names.index(axis)]] for axis in _AXES)
    return x, y, z


def _ascii(content: bytes, body: int, before: list[_Element], vertices: _Element) -> _Columns:
    first = sum(element.count for element in before)
    lines = content[body:].splitlines()
    rows = lines[first : first + vertices.count]
    if len(rows) < vertices.count:
        raise InvalidMap(f"the PLY states {vertices.count} vertices, but has {len(rows)} rows of them")
    table = number_table(b"\n".join(rows), "PLY", len(vertices.properties))
    if len(table) < vertices.count:
        raise InvalidMap(f"the PLY states {vertices.count} vertices, but {vertices.count - len(table)} rows are none")
    names = [name for name, _ in vertices.properties]
    x, y, z = (table[:, names.index(axis)] for axis in _AXES)
    return x, y, z
