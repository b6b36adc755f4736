"""Extents of mesh files: STL, COLLADA (DAE) and Wavefront OBJ, as rviz shows them.

A COLLADA file has its own unit, which counts, and an up axis, which does not (``mesh_loader.cpp`` of rviz).
"""

import math
import re
from collections.abc import Callable, Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element, ParseError

import numpy as np
from numpy.typing import NDArray

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput

Points = NDArray[np.float64]

MAX_BYTES = 256 << 20
"""Limit of the size of a mesh file [bytes]."""

MAX_DEPTH = 100
"""Limit of the nesting of nodes in a COLLADA file."""

MAX_POINTS = 1 << 24
"""Limit of the vertices that all nodes of a COLLADA file place."""

_NODE = 256
"""What a node that is placed counts of this."""

_HEADER, _FACET = 84, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""Bytes before the first facet of a binary STL file, and a facet."""


_CONTINUED = re.compile(rb"\\\r?\n")
"""End of a line of OBJ that goes on in the next one."""


class Extent(NamedTuple):
    """Least and greatest corner of a mesh, in its own units but for COLLADA, where they are metres."""

    least: tuple[float, float, float]
    greatest: tuple[float, float, float]


def extent_of(name: str, data: bytes) -> Extent:
    """Return the extent of a mesh.

    Parameters
    ----------
    name : str
        Name of the file; its ending determines the format.
    data : bytes
        The file.

    Raises
    ------
    InvalidInput
        The format is another one, or the file is damaged or has no vertex; the text names the file.
    """
    reader = READERS.get(name.lower().rpartition(".")[2])
    if reader is None:
        raise InvalidInput(f"mesh {name!r}: its format must be one of {', '.join(READERS)}")
    if len(data) > MAX_BYTES:
        raise InvalidInput(f"mesh {name!r} may have at most {MAX_BYTES >> 20} MiB")
    try:
        points = reader(data)
    except (ValueError, ParseError) as error:
        raise InvalidInput(f"mesh {name!r} cannot be read: {error}") from error
    if not len(points) or not np.isfinite(points).all():
        raise InvalidInput(f"mesh {name!r} has no vertex, or one that is not finite")
    least, greatest = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return Extent((least[0], least[1], least[2]), (greatest[0], greatest[1], greatest[2]))


def _stl(data: bytes) -> Points:
    """Return the vertices of an STL file; a binary one may begin with the word ``solid`` too."""
    count = int.from_bytes(data[_HEADER - 4 : _HEADER], "little")
    if len(data) >= _HEADER and len(data) >= _HEADER + count * _FACET.itemsize and (count or not _is_text(data)):
        facets = np.frombuffer(data, _FACET, count, _HEADER)
        return facets["corners"].reshape(-1, 3).astype(np.float64)
    if not _is_text(data):
        raise ValueError(f"it has {len(data)} bytes, too few for {count} facets")
    return _vertices(data.lower(), b"vertex")


def _is_text(data: bytes) -> bool:
    return data.lstrip()[:5].lower() == b"solid" and b"facet" in data[:4096].lower()


def _obj(data: bytes) -> Points:
    return _vertices(_CONTINUED.sub(b" ", data), b"v")


def _vertices(data: bytes, word: bytes) -> Points:
    rows = [line.split()[1:4] for line in data.splitlines() if line.split()[:1] == [word]]
    if any(len(row) < 3 for row in rows):
        raise ValueError(f"a line {word.decode()!r} has fewer than three numbers")
    return np.array(rows, np.float64).reshape(-1, 3)


def _dae(data: bytes) -> Points:
    try:
        from defusedxml.common import DefusedXmlException  # noqa: PLC0415 - of the extra plan
        from defusedxml.ElementTree import fromstring  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise InvalidInput(f"reading COLLADA meshes needs the extra plan: {install_hint('plan')}") from error
    try:
        root = fromstring(data, forbid_dtd=True)
    except DefusedXmlException as error:
        raise ValueError("it has a document type or entities") from error
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    unit = root.find("asset/unit")
    scale = float(unit.get("meter", "1")) if unit is not None else 1.0
    scene = _Scene(root)
    placed = [points for node in _shown(root).findall("node") for points in scene.placed(node, np.eye(4))]
    return np.concatenate(placed or list(scene.geometries.values()) or [np.empty((0, 3))]) * scale


def _shown(root: Element) -> Element:
    """Return the scene that a COLLADA file shows, of several in its library; the first if it names none."""
    scenes = root.findall("library_visual_scenes/visual_scene")
    named = root.find("scene/instance_visual_scene")
    wanted = "" if named is None else named.get("url", "")[1:]
    return next((each for each in scenes if each.get("id") == wanted), scenes[0] if scenes else root)


def _positions(geometry: Element) -> Points:
    """Return the vertices of a geometry; its normals and textures are other sources."""
    sources = {each.get("id", ""): each for each in geometry.iter("source")}
    found = [np.empty((0, 3))]
    for reference in geometry.iterfind("mesh/vertices/input[@semantic='POSITION']"):
        numbers = sources[name].find("float_array") if (name := reference.get("source", "")[1:]) in sources else None
        if numbers is not None and numbers.text:
            found.append(np.array(numbers.text.split(), np.float64).reshape(-1, 3))
    return np.concatenate(found)


class _Scene:
    """Geometries and nodes of a COLLADA file by their ids."""

    def __init__(self, root: Element) -> None:
        self.geometries = {each.get("id", ""): _positions(each) for each in root.iter("geometry")}
        self._nodes = {each.get("id", ""): each for each in root.iter("node")}
        self._points = 0

    def placed(self, node: Element, above: Points, depth: int = 0) -> Iterator[Points]:
        """Yield the vertices of a node and of those in it, by themselves or by reference, in the frame of the scene."""
        if depth > MAX_DEPTH:
            raise ValueError(f"its nodes are nested more than {MAX_DEPTH} deep, or in each other")
        here = above
        for child in node:
            if child.tag in _MOVES:
                here = here @ _MOVES[child.tag]([float(word) for word in (child.text or "").split()])
        for instance in node.findall("instance_geometry"):
            points = self.geometries.get(instance.get("url", "")[1:], np.empty((0, 3)))
            self._count(len(points))
            yield points @ here[:3, :3].T + here[:3, 3]
        others = [self._nodes.get(each.get("url", "")[1:]) for each in node.findall("instance_node")]
        for child in (*node.findall("node"), *(other for other in others if other is not None)):
            self._count(_NODE)
            yield from self.placed(child, here, depth + 1)

    def _count(self, points: int) -> None:
        """Raise ``ValueError`` if nodes that refer to each other make too large a scene."""
        self._points += points
        if self._points > MAX_POINTS:
            raise ValueError(f"its nodes place more than {MAX_POINTS} vertices")


def _matrix(numbers: list[float]) -> Points:
    return np.array(numbers).reshape(4, 4)


def _translate(numbers: list[float]) -> Points:
    moved = np.eye(4)
    moved[:3, 3] = numbers
    return moved


def _scale(numbers: list[float]) -> Points:
    return np.diag([*np.array(numbers).reshape(3), 1.0])


def _rotate(numbers: list[float]) -> Points:
    """Return the matrix of a rotation about an axis, by an angle in degrees (Rodrigues' formula)."""
    *axis, degrees = numbers
    x, y, z = np.array(axis).reshape(3) / (np.linalg.norm(axis) or 1.0)
    cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    angle, turned = math.radians(degrees), np.eye(4)
    turned[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return turned


_MOVES: dict[str, Callable[[list[float]], Points]] = {
    "matrix": _matrix, "translate": _translate, "scale": _scale, "rotate": _rotate,
}  # fmt: skip

READERS: dict[str, Callable[[bytes], Points]] = {"stl": _stl, "dae": _dae, "obj": _obj}
"""Reader of vertices by the ending of a file's name."""
