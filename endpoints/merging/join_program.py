"""Program that joins the pose graphs of several robots."""

import json
import sys
from pathlib import Path
from typing import Any

from endpoints.rest.maps.map_programs import be_program
from ppaas.errors import QuotaExceeded
from ppaas.mapping.merging.joint_map import join_maps
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from storage.staged_uploads import mapped


def join_files(groups: list[list[str]], to: Path) -> dict[str, Any]:
    """Join pose graphs, and write the joint map's.

    Parameters
    ----------
    groups : list of list of str
        Paths of the pose graphs; see ``ppaas.mapping.merging.joint_map.join_maps``.
    to : Path

    Returns
    -------
    dict
        ``places``, ``key_frames``.
    """
    joint = join_maps([[unpack_mapping(memoryview(mapped(Path(path)))) for path in group] for group in groups])
    with to.open("wb") as file:
        file.writelines(pack_mapping(joint.mapping))
    return {"places": joint.places, "key_frames": len(joint.mapping.frames)}


if __name__ == "__main__":
    be_program(
        lambda: join_files(json.loads(sys.argv[1]), Path(sys.argv[2])),
        QuotaExceeded("the maps are too large to be joined: map with fewer beams or key frames"),
    )
