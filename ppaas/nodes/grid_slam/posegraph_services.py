"""Services of pose graphs: they save a mapping, continue another one, and hand out the current one by pages."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from ppaas.errors import InvalidInput, PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.map_drawing import DrawingSettings
from ppaas.mapping.merging.united import frame_name
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.messages.base.message import Message
from ppaas.messages.slam_toolbox import (
    DeserializePoseGraph,
    DeserializePoseGraphRequest,
    GetPoseGraph,
    GetPoseGraphRequest,
    GetPoseGraphResponse,
    MatchType,
    SerializePoseGraph,
    SerializePoseGraphRequest,
    SerializePoseGraphResponse,
)
from ppaas.nodes.base import Context, Reply, Service
from ppaas.nodes.file_pages import FilePages
from ppaas.nodes.jobs import LongWork

# -- pages of a pose graph ---------------------------------------------------------------------------------------------


class PosegraphPages:
    """Serves the file of a mapping page by page.

    Parameters
    ----------
    context : Context
        Of the node.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._pages = FilePages("pose graph")

    def make(self, mapping: Mapping, done: Callable[[bytes | PPaaSError], None]) -> None:
        """Make the file of a mapping in a job, and call back with it."""
        self._context.start(LongWork(lambda _cancelled: b"".join(pack_mapping(mapping))), done)

    def serve(self, mapping: Mapping, offset: int, numbers: GetPoseGraphResponse, reply: Reply) -> None:
        """Reply with a page.

        Parameters
        ----------
        mapping : Mapping
            Of which a new file is made for the first page.
        offset : int
            Offset in the file [bytes].
        numbers : GetPoseGraphResponse
            Response without the page.
        reply : callable

        Raises
        ------
        InvalidInput
            There is no file to continue, or the offset is beyond its end.
        """
        if offset == 0:
            self.make(mapping, partial(self._first, numbers, reply))
        else:
            reply(self._page(numbers, offset))

    def forget(self) -> None:
        """Forget the file."""
        self._pages.forget()

    def _first(self, numbers: GetPoseGraphResponse, reply: Reply, file: bytes | PPaaSError) -> None:
        if isinstance(file, PPaaSError):
            reply(file)
            return
        self._pages.use(file)
        reply(self._page(numbers, 0))

    def _page(self, numbers: GetPoseGraphResponse, offset: int) -> GetPoseGraphResponse:
        numbers.data, numbers.size = self._pages.page(offset)
        return numbers


# -- services of pose graphs -------------------------------------------------------------------------------------------

SERIALIZE = Service("serialize_map", SerializePoseGraph)
DESERIALIZE = Service("deserialize_map", DeserializePoseGraph)
POSE_GRAPH = Service("pose_graph", GetPoseGraph)
SERVICES = (SERIALIZE, DESERIALIZE, POSE_GRAPH)

GraphSaver = Callable[[str, bytes, Callable[[PPaaSError | None], None]], None]
"""Saves the file of a pose graph by its name, then calls back with None or the error, now or later."""

GraphLoader = Callable[[str], bytes | memoryview]
"""Returns the file of a pose graph by its name; raises ``NotFound`` or another `PPaaSError`."""


class PoseGraphStore(NamedTuple):
    """Store of pose graphs; without one of its functions, the services that need it are unavailable.

    Parameters
    ----------
    save : callable, optional
    load : callable, optional
    """

    save: GraphSaver | None = None
    load: GraphLoader | None = None


NO_STORE = PoseGraphStore()


class LoadedGraph(NamedTuple):
    """Mapping to continue.

    Parameters
    ----------
    mapping : Mapping
    start : Pose2D or None
        Pose of the robot in the map frame; None for the pose of the first key frame.
    keeps : bool
        Whether the map grows; otherwise the robot is localized in it.
    """

    mapping: Mapping
    start: Pose2D | None
    keeps: bool


class PoseGraphServices:
    """Answers ``serialize_map``, ``deserialize_map`` and ``pose_graph``.

    Parameters
    ----------
    context : Context
        Of the node.
    store : PoseGraphStore
    drawing : DrawingSettings
        Of the map.
    closes : bool
        Whether loops of the map are closed.
    """

    def __init__(
        self, context: Context, store: PoseGraphStore, drawing: DrawingSettings, *, closes: bool = True
    ) -> None:
        self._store, self._drawing, self._closes = store, drawing, closes
        self._pages = PosegraphPages(context)

    def loading(self, name: str, start: Pose2D | None, *, keeps: bool) -> Callable[[], LoadedGraph]:
        """Return a function for any thread that loads the mapping of a name, and raises ``InvalidGraph`` if it cannot.

        Raises
        ------
        Unavailable
            There is no store.
        """
        load = self._store.load
        if load is None:
            raise Unavailable("pose graphs cannot be loaded here: name the map in the robot's file")
        return lambda: LoadedGraph(unpack_mapping(load(name)), start, keeps)

    def requested(self, request: DeserializePoseGraphRequest) -> Callable[[], LoadedGraph]:
        """Return the same for a call of ``deserialize_map``; raises as `loading`, and ``InvalidInput``."""
        given = request.match_type in (MatchType.START_AT_GIVEN_POSE, MatchType.LOCALIZE_AT_POSE)
        pose = request.initial_pose
        start = Pose2D(pose.x, pose.y, pose.theta)
        if not start.is_finite():
            raise InvalidInput("the initial pose must be three finite numbers")
        localizes = request.match_type == MatchType.LOCALIZE_AT_POSE
        return self.loading(request.filename, start if given else None, keeps=not localizes)

    def answer(self, request: Message, mapping: Mapping, reply: Reply, *, may_join: bool = False) -> None:
        """Answer ``serialize_map`` or ``pose_graph`` with the current mapping, and whether it may join a joint map.

        Raises
        ------
        Unavailable
            There is no store.
        InvalidInput
            The page does not exist.
        """
        if isinstance(request, SerializePoseGraphRequest):
            self._save(request.filename, mapping, reply)
        else:
            assert isinstance(request, GetPoseGraphRequest)
            numbers = self._numbers(mapping, may_join=may_join)
            if request.offset < 0:
                reply(numbers)
            else:
                self._pages.serve(mapping, request.offset, numbers, reply)

    def forget(self) -> None:
        """Forget the file whose pages were requested."""
        self._pages.forget()

    def _save(self, name: str, mapping: Mapping, reply: Reply) -> None:
        save = self._store.save
        if save is None:
            raise Unavailable("pose graphs cannot be saved here: publish the map with 'ppaas robot map'")

        def made(file: bytes | PPaaSError) -> None:
            if isinstance(file, PPaaSError):
                reply(file)
            else:
                save(name, file, lambda error: reply(error or SerializePoseGraphResponse()))

        self._pages.make(mapping, made)

    def _numbers(self, mapping: Mapping, *, may_join: bool) -> GetPoseGraphResponse:
        closures = int((mapping.graph.edges.kinds == EdgeKind.CLOSURE).sum())
        scans, frame = int(mapping.frames.scans[-1]) + 1, frame_name(mapping.frames) if may_join else ""
        counts = len(mapping.frames), mapping.graph.edge_count, closures
        return GetPoseGraphResponse("", 0, *counts, *self._drawing, scans, frame, self._closes)
