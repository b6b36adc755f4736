"""Merge of mappings in files: pose graphs in, the files of a map out."""

from collections.abc import Iterator
from typing import NamedTuple

from ppaas.mapping.map_drawing import DEFAULTS as DRAWING
from ppaas.mapping.map_drawing import draw_map
from ppaas.mapping.merging.merge import Merged, Progress, merge
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.maps.formats.map_files import save_map


class MergedFiles(NamedTuple):
    """Files of the map of a merge.

    Parameters
    ----------
    yaml, image : bytes
        Files of map_server.
    posegraph : iterator of bytes
        Pose graph, piece by piece.
    merged : Merged
    """

    yaml: bytes
    image: bytes
    posegraph: Iterator[bytes]
    merged: Merged


def merge_files(
    first: memoryview | bytes,
    second: memoryview | bytes,
    image_name: str,
    resolution: float = DRAWING.resolution,
    done: Progress | None = None,
) -> MergedFiles:
    """Merge the pose graphs of two maps, and draw the grid of the result.

    Parameters
    ----------
    first, second : bytes-like
        Pose graphs; the result is in the frame of the first.
    image_name : str
        Name of the image that the YAML file names.
    resolution : float
        Edge of a cell [m].
    done : callable, optional
        See `ppaas.mapping.merging.merge.merge`.

    Raises
    ------
    InvalidGraph
        A file is not a pose graph.
    MapsNotMerged
        See `ppaas.mapping.merging.merge.merge`.
    QuotaExceeded
        The mappings or the grid would be too large.
    """
    merged = merge(unpack_mapping(first), unpack_mapping(second), done=done)
    frames = merged.mapping.frames
    grid = draw_map(frames, frames.poses, DRAWING._replace(resolution=resolution))
    yaml, image = save_map(grid, image_name)
    return MergedFiles(yaml, image, pack_mapping(merged.mapping), merged)
