"""Shapes of links in a URDF, and their extent."""

import math
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidUrdf
from ppaas.robot_model.xml_document import MAX_NAME, numbers, required, sizes
from ppaas.transforms.spatial import Rigid

CORNERS = 32
"""Number of corners of the polygon around a disc; it exceeds the disc by at most 0.5 % of the radius."""

Points = NDArray[np.float64]

_TAGS = "<box>, <cylinder>, <capsule>, <sphere>, <mesh>"

_ANGLES = (np.arange(CORNERS) + 0.5) * (2.0 * math.pi / CORNERS)
_UNIT_RING = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)]) / math.cos(math.pi / CORNERS)


class BoxShape(NamedTuple):
    """Box, given by its least and greatest corner [m]."""

    least: tuple[float, float, float]
    greatest: tuple[float, float, float]


class CylinderShape(NamedTuple):
    """Cylinder along z, centred at the origin [m]."""

    radius: float
    length: float


class Capsule(NamedTuple):
    """Cylinder along z, centred at the origin, with a half-sphere on each end; the length is the cylinder's [m]."""

    radius: float
    length: float


class Sphere(NamedTuple):
    """Sphere, centred at the origin [m]."""

    radius: float


class Mesh(NamedTuple):
    """Mesh of unknown extent."""

    filename: str


Shape = BoxShape | CylinderShape | Capsule | Sphere | Mesh


@dataclass(frozen=True, slots=True)
class PlacedShape:
    """Shape of a link, and its pose in the link's frame."""

    shape: Shape
    origin: Rigid


def read_shapes(link: Element, kind: str, where: str) -> tuple[PlacedShape, ...]:
    """Return the shapes of a link.

    Parameters
    ----------
    link : Element
        The ``<link>``.
    kind : str
        ``"collision"`` or ``"visual"``.
    where : str
        Description of the link, for errors.

    Raises
    ------
    InvalidUrdf
        A shape is unknown, or has an invalid number.
    """
    found = [(required(each, "geometry", where), read_origin(each, where)) for each in link.findall(kind)]
    return tuple(PlacedShape(_shape(geometry, where), origin) for geometry, origin in found)


def read_origin(element: Element, where: str) -> Rigid:
    """Return the pose of an element's ``<origin>`` in its parent's frame; the identity if it has none.

    Raises
    ------
    InvalidUrdf
        A number is invalid, or the rotation is given twice or is the zero quaternion.
    """
    origin = element.find("origin")
    if origin is None:
        return Rigid()
    x, y, z = numbers(origin, "xyz", 3, where, "0 0 0")
    if "quat_xyzw" not in origin.attrib:
        return placed((x, y, z), numbers(origin, "rpy", 3, where, "0 0 0"))
    if "rpy" in origin.attrib:
        raise InvalidUrdf(f"{where}: an <origin> has rpy= and quat_xyzw=: give one of them")
    turn = np.array(numbers(origin, "quat_xyzw", 4, where))
    norm = float(np.linalg.norm(turn))
    if norm < 1e-6:
        raise InvalidUrdf(f"{where}: quat_xyzw= of an <origin> must be a rotation, not zero")
    return Rigid(x, y, z, *(turn / norm).tolist())


def placed(xyz: tuple[float, ...], rpy: tuple[float, ...]) -> Rigid:
    """Return the pose of a translation [m] and of rotations about the fixed axes x, y and z, in this order [rad]."""
    roll, pitch = turned((1.0, 0.0, 0.0), rpy[0]), turned((0.0, 1.0, 0.0), rpy[1])
    yaw = turned((0.0, 0.0, 1.0), rpy[2])
    x, y, z = xyz
    return Rigid(x, y, z) @ yaw @ pitch @ roll


def turned(axis: tuple[float, float, float], angle: float) -> Rigid:
    """Return the rotation by an angle [rad] about a unit axis."""
    s = math.sin(angle / 2.0)
    return Rigid(0.0, 0.0, 0.0, s * axis[0], s * axis[1], s * axis[2], math.cos(angle / 2.0))


def _shape(geometry: Element, where: str) -> Shape:
    found = next(iter(geometry), None)
    if found is None:
        raise InvalidUrdf(f"{where}: a <geometry> is empty: give it one of {_TAGS}")
    match found.tag:
        case "box":
            x, y, z = (edge / 2.0 for edge in sizes(found, "size", 3, where))
            return BoxShape((-x, -y, -z), (x, y, z))
        case "cylinder":
            return CylinderShape(*sizes(found, "radius", 1, where), *sizes(found, "length", 1, where))
        case "capsule":
            return Capsule(*sizes(found, "radius", 1, where), *sizes(found, "length", 1, where))
        case "sphere":
            return Sphere(*sizes(found, "radius", 1, where))
        case "mesh":
            return _mesh(found, where)
    tag = found.tag[:MAX_NAME]
    raise InvalidUrdf(f"{where}: a <geometry> must have one of {_TAGS}, not <{tag}>")


def _mesh(mesh: Element, where: str) -> Shape:
    """Return the box of a mesh with a ``bounding_box``, or else a mesh of unknown extent.

    ``bounding_box``, the least and the greatest x, y, z before scaling, is an extension that other programs ignore.
    """
    scale = numbers(mesh, "scale", 3, where, "1 1 1")
    if "bounding_box" not in mesh.attrib:
        return Mesh(mesh.get("filename", "")[:MAX_NAME])
    box = numbers(mesh, "bounding_box", 6, where)
    ends = [sorted((box[axis] * scale[axis], box[axis + 3] * scale[axis])) for axis in range(3)]
    if any(box[axis] > box[axis + 3] for axis in range(3)):
        raise InvalidUrdf(f"{where}: bounding_box= must be the least x, y, z of a mesh, followed by the greatest")
    (x0, x1), (y0, y1), (z0, z1) = ends
    return BoxShape((x0, y0, z0), (x1, y1, z1))


def outline_points(shape: Shape, pose: Rigid) -> Points:
    """Return (n, 2) points whose convex hull contains the shape seen from above [m]; none for a mesh.

    A circle is replaced by a polygon of ``CORNERS`` corners around it.
    """
    match shape:
        case BoxShape(least, greatest):
            return _moved(_corners(least, greatest), pose)[:, :2]
        case CylinderShape(radius, length):
            ring = _ring(radius)
            ends = [np.column_stack([ring, np.full(CORNERS, z)]) for z in (-length / 2.0, length / 2.0)]
            return _moved(np.concatenate(ends), pose)[:, :2]
        case Capsule(radius, length):
            middles = _moved(np.array([(0.0, 0.0, -length / 2.0), (0.0, 0.0, length / 2.0)]), pose)[:, None, :2]
            both: Points = (middles + _ring(radius)).reshape(-1, 2)
            return both
        case Sphere(radius):
            around: Points = _ring(radius) + np.array(pose[:2])
            return around
    return np.empty((0, 2))


def heights(shape: Shape, pose: Rigid) -> tuple[float, float]:
    """Return the lowest and the highest z of a shape other than a mesh [m]."""
    match shape:
        case BoxShape(least, greatest):
            z = _moved(_corners(least, greatest), pose)[:, 2]
            return float(z.min()), float(z.max())
        case CylinderShape(radius, length):
            up = _up(pose)
            reach = abs(up) * length / 2.0 + radius * math.sqrt(max(0.0, 1.0 - up * up))
            return pose.z - reach, pose.z + reach
        case Capsule(radius, length):
            reach = abs(_up(pose)) * length / 2.0 + radius
            return pose.z - reach, pose.z + reach
        case Sphere(radius):
            return pose.z - radius, pose.z + radius
    raise AssertionError("the height of a mesh is unknown")


def _up(pose: Rigid) -> float:
    """Return the cosine of the angle between the z axis of a pose and the vertical."""
    return 1.0 - 2.0 * (pose.qx * pose.qx + pose.qy * pose.qy)


def _corners(least: tuple[float, ...], greatest: tuple[float, ...]) -> Points:
    return np.array(list(product(*zip(least, greatest, strict=True))))


def _ring(radius: float) -> Points:
    around: Points = radius * _UNIT_RING
    return around


def _moved(points: Points, pose: Rigid) -> Points:
    moved: Points = points @ _axes(pose).T + pose[:3]
    return moved


def _axes(pose: Rigid) -> Points:
    """Return the (3, 3) rotation matrix of a pose."""
    x, y, z, w = pose[3:]
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
