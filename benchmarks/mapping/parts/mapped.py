"""Maps of whole logs, made once for all parts of the bench and handed from process to process in files."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ppaas.mapping.pipeline.offline import LogMap, map_log
from ppaas.mapping.scan_log import ScanLog
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.planar_poses import PoseArray


class Mapped(NamedTuple):
    """Map of a whole log.

    Parameters
    ----------
    mapping : Mapping
    poses : (n, 3) array
        Poses of the robot at all scans.
    """

    mapping: Mapping
    poses: PoseArray


def mapping_of(made: LogMap) -> Mapping:
    """Return the mapping of a log."""
    return Mapping(made.mapper.key_frames, made.mapper.graph)


def write(folder: Path, name: str, made: LogMap) -> None:
    """Write a map for `mapped`."""
    np.save(folder / f"{name}.npy", made.poses)
    with (folder / f"{name}.posegraph").open("wb") as file:
        file.writelines(pack_mapping(mapping_of(made)))


def mapped(folder: Path, name: str, read: Callable[[], ScanLog]) -> Mapped:
    """Return the map of a log; it is made and written if there is none of its name in the folder."""
    if not (folder / f"{name}.posegraph").exists():
        write(folder, name, map_log(read()))
    return Mapped(unpack_mapping((folder / f"{name}.posegraph").read_bytes()), np.load(folder / f"{name}.npy"))
