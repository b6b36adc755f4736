"""Program that merges the pose graphs of two maps and writes the files of the result."""

import sys
from pathlib import Path
from typing import Any

from endpoints.rest.maps.map_programs import be_program
from ppaas.errors import QuotaExceeded
from ppaas.mapping.merging.merged_files import merge_files
from storage.staged_uploads import mapped
from storage.versions import IMAGE, POSEGRAPH, YAML

IMAGE_NAME = "map.pgm"
"""Image that the YAML file names."""


def merge_to(first: Path, second: Path, resolution: float, folder: Path) -> dict[str, Any]:
    """Merge two files, and write the files of the map, named as its parts; see ``map_merge.merge_in_process``."""
    files = merge_files(memoryview(mapped(first)), memoryview(mapped(second)), IMAGE_NAME, resolution)
    (folder / YAML).write_bytes(files.yaml)
    (folder / IMAGE).write_bytes(files.image)
    with (folder / POSEGRAPH).open("wb") as graph:
        graph.writelines(files.posegraph)
    merged = files.merged
    return {
        "motion": [float(value) for value in merged.motion],
        "places": merged.matches,
        "support": merged.support,
        "confirmed": merged.confirmed,
    }


if __name__ == "__main__":
    given = sys.argv[1:]
    be_program(
        lambda: merge_to(Path(given[0]), Path(given[1]), float(given[2]), Path(given[3])),
        QuotaExceeded("the maps are too large to be merged: map with fewer beams or key frames"),
    )
