"""Program that merges the pose graphs of two maps and writes the files of the result; its output is JSON.

A process of its own: its kernels load slowly, and its memory is limited.
"""

import json
import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

from ppaas.errors import PPaaSError, Unavailable, rebuild

MEMORY = 4 << 30
"""Memory limit of the program [bytes]."""

SECONDS = 240.0
"""Time limit of a merge [s]. Halves of a drive of 400 m take 2 to 5 s, the first one longer to compile kernels."""

NICE = 5
"""Addition to the nice value: robots' containers come first."""

IMAGE_NAME = "map.pgm"
"""Image that the YAML file names."""


def merge_in_process(first: Path, second: Path, resolution: float, folder: Path) -> dict[str, Any]:
    """Run the program; blocks.

    Parameters
    ----------
    first, second : Path
        Pose graphs.
    resolution : float
        Edge of a cell of the grid [m].
    folder : Path
        Folder in which the files ``yaml``, ``image`` and ``posegraph`` are written.

    Returns
    -------
    dict
        ``motion``, ``places``, ``support``, ``confirmed``.

    Raises
    ------
    PPaaSError
        The error of the merge; ``Unavailable`` if it ran out of memory or time.
    """
    command = [sys.executable, "-m", "endpoints.rest.maps.merge_program"]
    arguments = [str(first), str(second), repr(resolution), str(folder)]
    try:
        process = subprocess.run(
            [*command, *arguments], capture_output=True, text=True, check=False, timeout=SECONDS
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        raise Unavailable(f"the maps were not merged within {SECONDS:g} s: merge smaller maps") from error
    if process.returncode:
        raise Unavailable(
            f"the maps could not be merged (exit status {process.returncode}): they may be too large for this machine"
        )
    answer: dict[str, Any] = json.loads(process.stdout)
    if "fault" in answer:
        raise rebuild(*answer["fault"])
    return answer


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
