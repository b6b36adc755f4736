"""Program that checks an OctoMap file and writes the error, if any, to standard output as JSON."""

import json
import resource
import sys
from pathlib import Path

from ppaas.errors import InvalidMap
from ppaas.maps.octomap import parse_octomap
from storage.staged_uploads import mapped

MEMORY = 4 << 30
"""Memory limit of the check [bytes]."""


def fault_of(path: Path) -> str:
    """Return the error of a file; an empty text if it is a valid octree."""
    try:
        parse_octomap(mapped(path))
    except InvalidMap as error:
        return str(error)
    except MemoryError:
        return "the octree is too large to be checked: publish it at a coarser resolution"
    return ""


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    sys.stdout.write(json.dumps({"fault": fault_of(Path(sys.argv[1]))}))
