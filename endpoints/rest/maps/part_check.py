"""Program that checks an octree or a pose graph."""

import sys
from collections.abc import Callable
from pathlib import Path

from endpoints.rest.maps.map_programs import be_program
from ppaas.errors import InvalidMap, PPaaSError
from ppaas.mapping.serialization.mapping_file import unpack_mapping
from ppaas.maps.octomap import parse_octomap
from storage.staged_uploads import Buffer, mapped
from storage.versions import OCTOMAP, POSEGRAPH

_PARSERS: dict[str, tuple[Callable[[Buffer], object], str]] = {
    OCTOMAP: (parse_octomap, "the octree is too large to be checked: publish it at a coarser resolution"),
    POSEGRAPH: (
        lambda data: unpack_mapping(memoryview(data)),
        "the pose graph is too large to be checked: map with fewer beams or key frames",
    ),
}
"""Parser of each part, and the error if it needs too much memory."""


def check(part: str, path: Path) -> None:
    """Parse a file; ``InvalidMap`` if it is not valid."""
    parse, _ = _PARSERS[part]
    try:
        parse(mapped(path))
    except PPaaSError as error:
        raise InvalidMap(str(error)) from error


if __name__ == "__main__":
    be_program(lambda: check(sys.argv[1], Path(sys.argv[2])), InvalidMap(_PARSERS[sys.argv[1]][1]))
