"""Run as a program: tells on standard output, as JSON, what is wrong with a file of OctoMap, if anything is."""

import json
import resource
import sys
from pathlib import Path

from ppaas.errors import InvalidMap
from ppaas.maps.octomap import parse_octomap
from storage.staged_uploads import mapped

MEMORY = 4 << 30
"""Most that an octree may take while it is looked at [bytes]."""


def fault_of(path: Path) -> str:
    """Return what is wrong with a file; nothing if it is an octree."""
    try:
        parse_octomap(mapped(path))
    except InvalidMap as error:
        return str(error)
    except MemoryError:
        return "the octree is too large to be looked at: read it at a coarser resolution, and publish that"
    return ""


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    sys.stdout.write(json.dumps({"fault": fault_of(Path(sys.argv[1]))}))
