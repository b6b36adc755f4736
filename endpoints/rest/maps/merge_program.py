"""Program that merges the pose graphs of two maps and writes the files of the result; its output is JSON.

A process of its own: its kernels load slowly, and its memory is limited.
"""

import json
import os
import resource
import sys
from pathlib import Path
from typing import Any

from ppaas.errors import PPaaSError

MEMORY = 4 << 30
"""Memory limit of the program [bytes]."""

NICE = 5
"""Addition to the nice value: robots' containers come first."""

IMAGE_NAME = "map.pgm"
"""Image that the YAML file names."""


def main(first: Path, second: Path, resolution: float, folder: Path) -> dict[str, Any]:
    """Merge two files; return the output of the program."""
    from ppaas.mapping.merging.merged_files import merge_files  # noqa: PLC0415 - the web process must not load kernels

    try:
        files = merge_files(first.read_bytes(), second.read_bytes(), IMAGE_NAME, resolution)
        (folder / "yaml").write_bytes(files.yaml)
        (folder / "image").write_bytes(files.image)
        with (folder / "posegraph").open("wb") as graph:
            graph.writelines(files.posegraph)
    except PPaaSError as error:
        return {"fault": [error.slug, str(error)]}
    except MemoryError:
        return {"fault": ["quota-exceeded", "the maps are too large to be merged: map with fewer beams or key frames"]}
    merged = files.merged
    return {
        "motion": [float(value) for value in merged.motion],
        "places": merged.matches,
        "support": merged.support,
        "confirmed": merged.confirmed,
    }


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    os.nice(NICE)
    given = sys.argv[1:]
    sys.stdout.write(json.dumps(main(Path(given[0]), Path(given[1]), float(given[2]), Path(given[3]))))
