"""The machine link: what passes between a container and the agent of its machine.

A container holds no keys of any store and opens no session on the fabric. It asks its agent, which knows whose it is.
"""

from typing import Any

import msgspec

from engine.protocols.robot_link import Refusal
from ppaas.plans.history import LinkHistory, PlannerHistory
from storage.records import PlanRecord


class Attach(msgspec.Struct, tag="attach"):
    """The container says who it is."""

    container: str
    secret: str


class SaveClone(msgspec.Struct, tag="save_clone"):
    """Keep the checkpoint of the clone."""

    request: int
    nodes: dict[str, bytes]


class KeepPlan(msgspec.Struct, tag="keep_plan"):
    """Keep a plan."""

    request: int
    plan: PlanRecord


class FindPlans(msgspec.Struct, tag="find_plans"):
    """Find plans on the container's map version, for who would compute with this planner (``PlanQuery``)."""

    request: int
    start: tuple[float, float]
    goal: tuple[float, float]
    planner: str
    parameters: dict[str, Any]
    robot_radius: float
    tolerance: float
    kinematic: bool


class AskHistory(msgspec.Struct, tag="ask_history"):
    """Tell what is known of planning on the container's map."""

    request: int


class NoteHistory(msgspec.Struct, tag="note_history"):
    """Add to the history; it may be lost."""

    rows: list[PlannerHistory]
    link: LinkHistory | None = None


class PrepareIndex(msgspec.Struct, tag="prepare_index"):
    """Put what a planner prepares of the container's map beside its layers, for all containers there."""

    request: int
    planner: str


class Share(msgspec.Struct, tag="share"):
    """Publish on the fabric, as JSON; it may be lost."""

    topic: str
    payload: bytes


FromContainer = Attach | SaveClone | KeepPlan | FindPlans | AskHistory | NoteHistory | PrepareIndex | Share


class Done(msgspec.Struct, tag="done"):
    """A request was carried out, or why not."""

    request: int
    refusal: Refusal | None = None


class Candidate(msgspec.Struct):
    """A plan that was found: all of it, or the stretch between both ends."""

    plan: PlanRecord
    whole: bool = True


class PlansFound(msgspec.Struct, tag="found_plans"):
    """Plans worth a look, the best first."""

    request: int
    plans: list[Candidate]


class PlanningHistory(msgspec.Struct, tag="history"):
    """What is known of planning on a map, and of the link to the store."""

    request: int
    rows: list[PlannerHistory]
    link: str
    measured: LinkHistory | None


class Shared(msgspec.Struct, tag="shared"):
    """What a robot of the same map published."""

    user: str
    robot: str
    topic: str
    payload: bytes


class Resized(msgspec.Struct, tag="resized"):
    """The container has another size from now on: its kernels may use so many threads."""

    threads: int


class EndpointCame(msgspec.Struct, tag="endpoint_came"):
    """An endpoint is there that awaits the container: what was lost is dialled at once."""


Answer = Done | PlansFound | PlanningHistory

ToContainer = Answer | Shared | Resized | EndpointCame
