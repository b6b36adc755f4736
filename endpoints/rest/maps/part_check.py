"""Program that checks an octree or a pose graph and writes the error, if any, to standard output as JSON."""

import json
import resource
import sys
from collections.abc import Callable
from pathlib import Path

from ppaas.errors import PPaaSError
from ppaas.mapping.serialization.mapping_file import unpack_mapping
from ppaas.maps.octomap import parse_octomap
from storage.staged_uploads import Buffer, mapped
from storage.versions import OCTOMAP, POSEGRAPH

MEMORY = 4 << 30
"""Memory limit of the check [bytes]."""

_PARSERS: dict[str, tuple[Callable[[Buffer], object], str]] = {
    OCTOMAP: (parse_octomap, "the octree is too large to be checked: publish it at a coarser resolution"),
    POSEGRAPH: (
        lambda data: unpack_mapping(memoryview(data)),
        "the pose graph is too large to be checked: map with fewer beams or key frames",
    ),
}
"""Parser of each part, and the error if it needs too much memory."""


def fault_of(part: str, path: Path) -> str:
    """Return the error of a file; an empty text if it is valid."""
    parse, too_large = _PARSERS[part]
    try:
        parse(mapped(path))
    except PPaaSError as error:
        return str(error)
    except MemoryError:
        return too_large
    return ""


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    sys.stdout.write(json.dumps({"fault": fault_of(sys.argv[1], Path(sys.argv[2]))}))
