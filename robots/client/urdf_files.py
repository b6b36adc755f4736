"""URDF files of a robot, with the extents of the meshes that they name."""

import os
import re
from collections.abc import Iterable, Mapping
from functools import cache
from html import unescape
from pathlib import Path
from urllib.parse import unquote

from ppaas.errors import InvalidInput
from ppaas.robot_model.mesh_extents import MAX_BYTES, READERS, Extent, extent_of
from robots.client.xacro_files import expand_xacro, is_xacro

MAX_URDF = 1 << 20
"""Limit of the size of a URDF [bytes]."""

ABOVE = 3
"""Number of folders above a URDF in which packages are looked for: a URDF is usually in ``PACKAGE/urdf``."""

_COLLISION = re.compile(r"<collision[\s>].*?</collision>", re.DOTALL)
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_MESH = re.compile(r"<mesh\b(?P<attributes>[^<>]*)>")
_FILENAME = re.compile(r"""\bfilename\s*=\s*(?:"([^"]*)"|'([^']*)')""")


def read_urdf_file(path: Path, folders: Iterable[Path] = (), arguments: Mapping[str, str] | None = None) -> bytes:
    """Return the bytes of a URDF, with a ``bounding_box`` for each mesh whose file is found; xacro is expanded.

    The cloud gets no mesh files. So that it knows the size of a robot, each ``<mesh>`` of a collision, or of a visual
    if there is no collision, gets its extent here. Everything else is unchanged.

    Parameters
    ----------
    path : Path
    folders : iterable of Path
        Folders of packages or of their meshes. ``package://NAME/…`` is also looked for in the folders above the URDF,
        in ``ROS_PACKAGE_PATH`` and in ``AMENT_PREFIX_PATH``; so are the packages of xacro.
    arguments : mapping of str to str, optional
        Arguments of a xacro file.

    Raises
    ------
    InvalidInput
        The file or a mesh cannot be read, or the file is xacro that cannot be expanded.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read the URDF: {error}") from error
    known = [*folders, *_near(path), *_installed()]
    if is_xacro(path, data):
        data = expand_xacro(path, known, arguments or {})
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        text = ""
    if not text or len(data) > MAX_URDF:
        return data  # the cloud refuses it with a reason
    return _with_boxes(text, known).encode()


def _with_boxes(text: str, folders: list[Path]) -> str:
    box_of = cache(lambda file: _text(_read(file)))  # wheels share a mesh

    def boxed(mesh: re.Match[str]) -> str:
        name = _FILENAME.search(mesh["attributes"])
        if name is None or "bounding_box" in mesh["attributes"]:
            return mesh[0]
        file = _found(unescape(name[1] or name[2] or ""), folders)
        return mesh[0] if file is None else f'<mesh bounding_box="{box_of(file)}"{mesh["attributes"]}>'

    if _COLLISION.search(_COMMENT.sub("", text)):
        return _COLLISION.sub(lambda collision: _MESH.sub(boxed, collision[0]), text)
    return _MESH.sub(boxed, text)


def _read(file: Path) -> Extent:
    try:
        if file.stat().st_size > MAX_BYTES:
            raise InvalidInput(f"mesh {str(file)!r} may have at most {MAX_BYTES >> 20} MiB")
        return extent_of(str(file), file.read_bytes())
    except OSError as error:
        raise InvalidInput(f"cannot read the mesh {str(file)!r}: {error}") from error


def _found(name: str, folders: list[Path]) -> Path | None:
    """Return the file of a mesh by its name in a URDF, None if it is not found, or has no ending of a mesh."""
    if name.lower().rpartition(".")[2] not in READERS:
        return None
    scheme, separator, rest = name.partition("://")
    rest = unquote(rest)
    inner = Path((rest if separator else name).lstrip("/"))
    if not separator or scheme == "file":
        candidates = [Path("/") / inner if separator or name.startswith("/") else folder / inner for folder in folders]
    else:
        below = Path(*inner.parts[1:])
        candidates = [folder / part for part in (inner, below, Path(inner.name)) for folder in folders]
    return next((file for file in candidates if file.is_file()), None)


def _near(path: Path) -> list[Path]:
    """Return the folder of a file and those above it."""
    folder = path.resolve().parent
    return [folder, *list(folder.parents)[:ABOVE]]


def _installed() -> list[Path]:
    """Return the folders in which ROS finds packages."""
    first = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    second = [f"{prefix}/share" for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
    return [Path(folder) for folder in (*first, *second) if folder]


def _text(extent: Extent) -> str:
    return " ".join(f"{number:.9g}" for number in (*extent.least, *extent.greatest))
