"""What the stores keep."""

from typing import Any, Literal

import msgspec

Role = Literal["admin", "user"]

PlanOrigin = Literal["computed", "reused", "stitched", "given"]


class Limits(msgspec.Struct, frozen=True, omit_defaults=True):
    """What a user may have, where that is not what every user may; ``engine.master.quotas`` tells what each counts."""

    containers: int | None = None
    cores: float | None = None
    robots: int | None = None
    maps: int | None = None
    plans_per_minute: int | None = None


class User(msgspec.Struct, frozen=True):
    """Who may use the cloud. ``password_hash`` is argon2id's own string."""

    id: str
    password_hash: str
    role: Role = "user"
    limits: Limits = Limits()


class Token(msgspec.Struct, frozen=True):
    """A login. Only the hash of the token is kept; ``expires`` and ``created`` are seconds since the epoch."""

    hash: str
    user: str
    expires: float
    created: float = 0.0


class MapFile(msgspec.Struct, frozen=True):
    """A file of a map, told by what is in it; ``size`` is in bytes."""

    sha256: str
    size: int


class MapVersionRecord(msgspec.Struct, frozen=True):
    """A version of a map as it became the present one: who published it, when [s since the epoch] and why.

    ``number`` goes up from publication to publication, with gaps. ``files`` are those that there are of ``yaml``,
    ``image`` and ``octomap``; ``version`` is the hash of all of them. ``restored`` is one that had been there before.
    """

    number: int
    version: str
    created: float
    author: str
    message: str = ""
    restored: bool = False
    files: dict[str, MapFile] = {}


class MapRecord(msgspec.Struct, frozen=True):
    """A map and one of its versions, the present one unless another was asked for; its files are read elsewhere.

    A map is seen by its owner and its readers; ``"*"`` among the readers makes it public.
    """

    id: str
    owner: str
    present: MapVersionRecord
    readers: tuple[str, ...] = ()
    description: str = ""

    @property
    def version(self) -> str:
        """The hash of its files."""
        return self.present.version

    @property
    def created(self) -> float:
        """When this version was published [s since the epoch]."""
        return self.present.created

    def readable_by(self, user: str) -> bool:
        """Tell whether a user may see the map and plan on it."""
        return user == self.owner or user in self.readers or "*" in self.readers


class Publication(msgspec.Struct, frozen=True):
    """What is said when a version of a map is made the present one.

    Parameters
    ----------
    map, author : str
        Which map, and who says so.
    created : float
        When [s since the epoch].
    message : str
        Why.
    owner : str, optional
        Whose map it is; its author's, if nothing is said.
    readers, description : optional
        None is what was before.
    if_match : str, optional
        The version that must be the present one, if the publication is to take place.
    """

    map: str
    author: str
    created: float
    message: str = ""
    owner: str | None = None
    readers: tuple[str, ...] | None = None
    description: str | None = None
    if_match: str | None = None


class RobotRecord(msgspec.Struct, frozen=True):
    """A robot: the JSON file that its maker writes.

    ``initial_pose`` is x [m], y [m], yaw [rad] in the map; ``cores`` the decimal size of its container; ``properties``
    is any JSON object, which we keep and do not read; ``labels`` are those that the machine of its container must have.
    Its URDF is kept beside it.
    """

    id: str
    user: str
    map: str
    model: str = "turtlebot2"
    initial_pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    cores: float = 1.0
    base_global_planner: str = "dijkstra"
    base_local_planner: str = "dwa"
    parameters: dict[str, Any] = {}
    description: str = ""
    properties: dict[str, Any] = {}
    labels: dict[str, str] = {}


class PlanRecord(msgspec.Struct, frozen=True):
    """A plan that was made: ``poses`` is the (n, 7) float64 array, little-endian, row by row.

    ``parameters`` are the planner's; ``origin`` tells whether it was computed, found among stored plans, joined of
    one and what was computed to reach it, or given by a program, which may say of it what it likes.
    The *head* of a plan is all but its poses (empty bytes).
    """

    id: str
    user: str
    map: str
    version: str
    planner: str
    start: tuple[float, float, float]
    goal: tuple[float, float, float]
    length: float
    cost: float
    seconds: float
    poses: bytes
    created: float
    robot: str | None = None
    parameters: dict[str, Any] = {}
    origin: PlanOrigin = "computed"


class PlanPassage(msgspec.Struct, frozen=True):
    """A stored plan that passes near two places: its head, and its waypoints nearest to them, the second later."""

    head: PlanRecord
    first: int
    last: int


class PlanPart(msgspec.Struct, frozen=True):
    """A stretch of a plan that is an entry of its own, which any number of plans share.

    ``first`` is its first waypoint in the plan, ``count`` how many it has, ``plans`` how often plans refer to it.
    """

    entry: str
    first: int
    count: int
    plans: int


class PlanStatistics(msgspec.Struct, frozen=True):
    """What stored plans take.

    ``waypoints`` counts those of all plans, ``kept`` those that are kept for them, ``entries`` the stretches that plans
    share; ``bytes`` is what plans and entries take, without indexes.
    """

    plans: int = 0
    waypoints: int = 0
    kept: int = 0
    entries: int = 0
    bytes: int = 0


class CloneCheckpoint(msgspec.Struct, frozen=True):
    """What a robot's clone needs to go on in another container: the state of each node, as the node wrote it."""

    user: str
    robot: str
    nodes: dict[str, bytes]
    saved: float
