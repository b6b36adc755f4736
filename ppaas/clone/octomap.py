"""3D mapping of a clone: ``octomap_server``, for robots that have parameters for it or map with a depth camera."""

from collections.abc import Callable

from ppaas.clone.node_parameters import NodeParameters
from ppaas.nodes.base import Context, Node
from ppaas.nodes.frames import FrameNames
from ppaas.thread_budget import Threads

OCTOMAP_SERVER = "octomap_server"
"""Node that makes a 3D map."""


def octomap_makers(
    given: NodeParameters, names: FrameNames, threads: Threads, *, wanted: bool
) -> dict[str, Callable[[Context], Node]]:
    """Return the maker of the node, if there are parameters for it or it is wanted without.

    Raises
    ------
    InvalidParameter
        A parameter is unknown, invalid, or not supported.
    Unavailable
        Clouds are to be registered, and the library for it is not installed.
    """
    if not (wanted or given.has(OCTOMAP_SERVER)):
        return {}
    # Imported only here, so that not every container loads its kernels.
    from ppaas.mapping.volume.registration import library  # noqa: PLC0415
    from ppaas.nodes.octomap_server.node import OctomapServerNode  # noqa: PLC0415
    from ppaas.nodes.octomap_server.parameters import OctomapServerParameters, spelled  # noqa: PLC0415

    parameters = given.read(OctomapServerParameters, OCTOMAP_SERVER, spelled(given.take(OCTOMAP_SERVER)))
    if parameters.registration:
        library()
    own = FrameNames.of(parameters.odom_frame_id, parameters.base_frame_id, parameters.frame_id, parameters.tf_prefix)
    frames = names if own == FrameNames() else own
    return {OCTOMAP_SERVER: lambda context: OctomapServerNode(context, parameters, threads, frames)}
