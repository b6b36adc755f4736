"""The machine link: what passes between a container and the agent of its machine.

A container holds no keys of any store and opens no session on the fabric. It asks its agent, which knows whose it is.
"""

import msgspec

from engine.link import Refusal
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


class PrepareIndex(msgspec.Struct, tag="prepare_index"):
    """Put what a planner prepares of the container's map beside its layers, for all containers there."""

    request: int
    planner: str


class Share(msgspec.Struct, tag="share"):
    """Publish on the fabric, as JSON; it may be lost."""

    topic: str
    payload: bytes


FromContainer = Attach | SaveClone | KeepPlan | PrepareIndex | Share


class Done(msgspec.Struct, tag="done"):
    """A request was carried out, or why not."""

    request: int
    refusal: Refusal | None = None


class Shared(msgspec.Struct, tag="shared"):
    """What a robot of the same map published."""

    user: str
    robot: str
    topic: str
    payload: bytes


ToContainer = Done | Shared
