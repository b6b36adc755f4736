"""Program that makes one complete file of recorded ones, with the topics that a caller may subscribe to."""

import json
import os
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from endpoints.rest.maps.map_programs import be_program
from engine.rights.globs import matches
from ppaas.errors import Unavailable
from ppaas.recording.writer import McapCopy
from storage.store_errors import disk_errors


def assemble(sources: list[Path], target: int, readable: list[list[str]]) -> dict[str, Any]:
    """Write the file; return the numbers of messages and of incomplete files.

    Parameters
    ----------
    sources : list of Path
        Files in the order of time; those that were removed meanwhile are left out.
    target : int
        Descriptor of an empty file, which is closed.
    readable : list of list of str
        Lists of globs; a topic must match one of each.
    """
    with disk_errors(Path(tempfile.gettempdir())), ExitStack() as stack:
        opened = [stack.enter_context(path.open("rb")) for path in sources if path.exists()]
        with os.fdopen(target, "wb") as output:
            copy = McapCopy(output, lambda topic: all(matches(topic, globs) for globs in readable))
            return copy.copy(opened)._asdict()


def main(arguments: dict[str, Any]) -> None:
    """Assemble the files that arguments name."""
    sources = [Path(source) for source in arguments["sources"]]
    be_program(
        lambda: assemble(sources, arguments["target"], arguments["readable"]),
        Unavailable("the recording is too large to be put together on this machine"),
    )


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
