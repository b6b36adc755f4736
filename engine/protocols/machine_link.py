"""Machine link: messages between a container and the agent of its machine.

A container has no credentials of any store and no session on the fabric. It sends requests to its agent, which knows
its user and robot. ``trace`` of a request is the ``traceparent`` of what it is made for; empty for none.
"""

from typing import Any

import msgspec

from engine.protocols.refusals import Refusal
from engine.protocols.versions import UNSTATED, Protocols
from engine.specs.containers import MapVersion
from ppaas.plans.history import LinkHistory, PlannerHistory
from ppaas.plans.stored import StoredPlan
from ppaas.tracing.spans import SpanRecord
from storage.plan_checks import array_of
from storage.records import CloneLogChange, PlanRecord


class AttachContainer(msgspec.Struct, tag="attach"):
    """Handshake of a container, which may be of another release than the agent if it is started from an image."""

    container: str
    secret: str
    protocols: Protocols = UNSTATED


class Compiling(msgspec.Struct, tag="compiling"):
    """First and only frame on a separate connection: a container compiles a kernel until it closes this."""

    container: str
    secret: str


class AwaitKernels(msgspec.Struct, tag="await_kernels"):
    """First and only frame on a separate connection: modules are to be compiled before others.

    The answer comes once they are, or after a time ``within`` [s]; without it there is no time limit.
    """

    container: str
    secret: str
    modules: list[str]
    within: float | None = None


class SaveClone(msgspec.Struct, tag="save_clone"):
    """Store the checkpoint of the clone, and the changes of the logs of its nodes."""

    request: int
    nodes: dict[str, bytes]
    changes: list[CloneLogChange] = []
    trace: str = ""


class ReadLog(msgspec.Struct, tag="read_log"):
    """Request the entries of the log of a node after a number; the answer may have only some of them."""

    request: int
    node: str
    after: int


class KeepPlan(msgspec.Struct, tag="keep_plan"):
    """Store a plan."""

    request: int
    plan: PlanRecord
    trace: str = ""


class FindPlans(msgspec.Struct, tag="find_plans"):
    """Find stored plans on the container's map version that can replace a plan of this planner (``PlanQuery``)."""

    request: int
    start: tuple[float, float]
    goal: tuple[float, float]
    planner: str
    parameters: dict[str, Any]
    robot_radius: float
    tolerance: float
    kinematic: bool
    trace: str = ""


class AskHistory(msgspec.Struct, tag="ask_history"):
    """Request the planning history of the container's map."""

    request: int


class NoteHistory(msgspec.Struct, tag="note_history"):
    """Add to the planning history, and to the counts of ``engine.specs.work_counts``. The message may be lost."""

    rows: list[PlannerHistory]
    link: LinkHistory | None = None
    counts: dict[str, int] = {}


class PrepareIndex(msgspec.Struct, tag="prepare_index"):
    """Build the index of a planner beside the layers of the container's map, for all containers of the machine."""

    request: int
    planner: str
    trace: str = ""


class FabricPublish(msgspec.Struct, tag="share"):
    """Publish JSON on the fabric. The message may be lost.

    Parameters
    ----------
    addressee : str
        Robot that alone receives it, as only a traffic node may say; empty for all that receive the topic.
    """

    topic: str
    payload: bytes
    addressee: str = ""


class MapInUse(msgspec.Struct, tag="map_in_use"):
    """Answer to ``UseLayers``: the clone uses them from now on, or refused them and goes on with those before."""

    map: MapVersion
    refusal: Refusal | None = None


class RecordBatch(msgspec.Struct, tag="record"):
    """Write a batch of messages (`ppaas.recording.batches`) to the recordings of the robot. It may be lost."""

    batch: bytes


class SpansEnded(msgspec.Struct, tag="spans"):
    """Spans of the container that have ended, and the number of further ones that it has dropped."""

    spans: list[SpanRecord]
    dropped: int = 0


Unanswered = NoteHistory | FabricPublish | MapInUse | RecordBatch | SpansEnded
"""Frames of a container that have no answer."""

FromContainer = (
    AttachContainer
    | Compiling
    | AwaitKernels
    | SaveClone
    | ReadLog
    | KeepPlan
    | FindPlans
    | AskHistory
    | PrepareIndex
    | Unanswered
)


class Done(msgspec.Struct, tag="done"):
    """A request was executed, or refused."""

    request: int
    refusal: Refusal | None = None


class PlanCandidate(msgspec.Struct):
    """A stored plan: the whole plan, or its segment between the requested ends."""

    plan: PlanRecord
    whole: bool = True


class PlansFound(msgspec.Struct, tag="found_plans"):
    """Stored plans, the best first."""

    request: int
    plans: list[PlanCandidate]


class LogRead(msgspec.Struct, tag="log_read"):
    """Entries of a log, sorted by number; none if there are no more."""

    request: int
    entries: list[tuple[int, bytes]]


class PlanningHistory(msgspec.Struct, tag="history"):
    """Planning history of a map, and measurements of the link to the store."""

    request: int
    rows: list[PlannerHistory]
    link: str
    measured: LinkHistory | None


class Shared(msgspec.Struct, tag="shared"):
    """A message that a robot on the same map has published."""

    user: str
    robot: str
    topic: str
    payload: bytes


class SharedBatch(msgspec.Struct, tag="shared_batch"):
    """Messages that robots on the same map have published, perhaps one of this container among them."""

    messages: list[Shared]


class Resized(msgspec.Struct, tag="resized"):
    """The container was resized; its kernels may use this number of threads."""

    threads: int


class EndpointCame(msgspec.Struct, tag="endpoint_came"):
    """A new endpoint waits for the container, which dials it at once if its robot link is lost."""


class RecorderTold(msgspec.Struct, tag="recorder_told"):
    """Answer of the recorder of the machine: see `ppaas.nodes.recorder.node.RecorderNode.told`."""

    problem: str = ""
    forgotten: bool = False
    lost: int = 0


class UseLayers(msgspec.Struct, tag="use_layers"):
    """Other versions of map and masks are in shared memory: the clone is to go on with them, and to answer.

    Parameters
    ----------
    map, masks, in_space
        As in the spec of the container and of its robot from now on.
    layers : str
        Folder of the layers.
    changes : list of tuple of int, optional
        Rectangles of cells that differ from the map before (``ppaas.maps.cell_rectangle``); None if size or origin of
        the map differ.
    """

    map: MapVersion
    masks: dict[str, MapVersion]
    in_space: bool
    layers: str
    changes: list[tuple[int, int, int, int]] | None


Answer = Done | PlansFound | LogRead | PlanningHistory

ToContainer = Answer | Shared | SharedBatch | Resized | EndpointCame | UseLayers | RecorderTold


def stored_plan(candidate: PlanCandidate) -> StoredPlan:
    """Return a candidate as a stored plan."""
    plan = candidate.plan
    poses = array_of(plan.poses)
    return StoredPlan(
        plan.id, plan.version, plan.planner, plan.start, plan.goal, plan.length, poses, candidate.whole,
        plan.parameters, plan.origin == "given",
    )  # fmt: skip
