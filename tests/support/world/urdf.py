"""URDF documents for tests."""

import struct
from collections.abc import Iterable, Sequence
from itertools import product

from tests.support.sources import ROOT

EXAMPLES = ROOT / "docs" / "examples" / "robots"


def example(name: str) -> bytes:
    """Return one of the example URDF files of the documentation."""
    return (EXAMPLES / f"{name}.urdf").read_bytes()


def text(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, numbers))


def origin(xyz: Sequence[float] = (0, 0, 0), rpy: Sequence[float] = (0, 0, 0)) -> str:
    return f'<origin xyz="{text(xyz)}" rpy="{text(rpy)}"/>'


def box(*size: float) -> str:
    return f'<box size="{text(size)}"/>'


def cylinder(radius: float, length: float) -> str:
    return f'<cylinder radius="{radius!r}" length="{length!r}"/>'


def capsule(radius: float, length: float) -> str:
    return f'<capsule radius="{radius!r}" length="{length!r}"/>'


def sphere(radius: float) -> str:
    return f'<sphere radius="{radius!r}"/>'


def part(geometry: str, at: str = "", kind: str = "collision") -> str:
    return f"<{kind}>{at}<geometry>{geometry}</geometry></{kind}>"


def link(name: str, *parts: str) -> str:
    return f'<link name="{name}">{"".join(parts)}</link>'


def joint(child: str, parent: str = "base_link", kind: str = "fixed", *inside: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{child}_joint" type="{kind}">{ends}{"".join(inside)}</joint>'


def urdf(*inside: str) -> bytes:
    return f'<?xml version="1.0"?><robot name="r">{"".join(inside)}</robot>'.encode()


def box_stl(least: Sequence[float], greatest: Sequence[float]) -> bytes:
    """Return a binary STL file with facets between the corners of a box."""
    corners = list(product(*zip(least, greatest, strict=True)))
    facets = [corners[0:3], corners[3:6], corners[5:8]]
    numbers = [[0.0, 0.0, 0.0, *(number for corner in facet for number in corner)] for facet in facets]
    body = b"".join(struct.pack("<12fH", *row, 0) for row in numbers)
    return b"made by hand".ljust(80, b"\0") + struct.pack("<I", len(facets)) + body
