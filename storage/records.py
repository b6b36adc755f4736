"""Records of the stores: users, tokens, maps, robots, plans, checkpoints, tasks and leases."""

from typing import Any, Literal

import msgspec

from ppaas.errors import Conflict, InvalidInput
from ppaas.tasks.records import Task
from storage.names import check_name
from storage.sharing_records import ProvidedIdentity, Share, TokenScope

Role = Literal["admin", "user"]

PlanOrigin = Literal["computed", "reused", "stitched", "given"]

LONGEST_HOLDER = 256
"""Limit of the name of the holder of a lease [characters]."""


class Limits(msgspec.Struct, frozen=True, omit_defaults=True):
    """Quotas of one user that differ from the defaults; ``engine.master.quotas`` defines what each of them counts."""

    containers: int | None = None
    cores: float | None = None
    robots: int | None = None
    maps: int | None = None
    plans_per_minute: int | None = None
    stored_bytes: int | None = None
    versions_per_map: int | None = None


class User(msgspec.Struct, frozen=True):
    """A user's account.

    ``password_hash`` is a string in the format of argon2id. ``groups`` are the names of the groups of users that it is
    in; a group exists while a user is in it. ``rapyuta_hash`` is the argon2id hash of the SHA-256 hash of a password by
    which robots of Rapyuta log in; empty if none may. ``since`` is the time at which the user was created [s since the
    epoch]: what is older is of a former user of the id. A user who is ``leaving`` has no rights any more, and the id is
    free once all that names the user is removed. ``identity`` is who logs in as this user with an identity provider;
    None if nobody does.
    """

    id: str
    password_hash: str
    role: Role = "user"
    limits: Limits = Limits()
    groups: tuple[str, ...] = ()
    rapyuta_hash: str = ""
    since: float = 0.0
    leaving: bool = False
    identity: ProvidedIdentity | None = None


class Token(msgspec.Struct, frozen=True):
    """A login, or a token for some robots.

    Only the hash of the token is stored; ``expires`` and ``created`` are seconds since the epoch. ``scope`` limits its
    rights; None if it has all rights of its user. ``name`` says what a scoped token is for. ``provider_session`` is the
    session at the identity provider with which the user logged in; empty if the provider did not name it, None for
    other logins.
    """

    hash: str
    user: str
    expires: float
    created: float = 0.0
    scope: TokenScope | None = None
    name: str = ""
    provider_session: str | None = None


class MapFile(msgspec.Struct, frozen=True):
    """A file of a map, identified by its content; ``size`` is in bytes."""

    sha256: str
    size: int


class MapVersionRecord(msgspec.Struct, frozen=True):
    """A publication of a map version: its author, its time [s since the epoch] and the message.

    ``number`` increases from publication to publication, with gaps. The keys of ``files`` are some of ``yaml``,
    ``image``, ``octomap`` and ``posegraph``; ``version`` is the hash over all files. ``restored`` marks a rollback to
    an earlier version.
    """

    number: int
    version: str
    created: float
    author: str
    message: str = ""
    restored: bool = False
    files: dict[str, MapFile] = {}


class MapRecord(msgspec.Struct, frozen=True):
    """A map with one of its versions: the current one, unless another was requested. It does not contain the files.

    The owner and the readers can see a map; ``"*"`` among the readers makes it public. With ``traffic``, all robots on
    it take part in its traffic.
    """

    id: str
    owner: str
    present: MapVersionRecord
    readers: tuple[str, ...] = ()
    description: str = ""
    traffic: bool = False

    @property
    def version(self) -> str:
        """The hash of its files."""
        return self.present.version

    @property
    def created(self) -> float:
        """Time at which this version was published [s since the epoch]."""
        return self.present.created

    def readable_by(self, user: str) -> bool:
        """Return whether a user may see the map and plan on it."""
        return user == self.owner or user in self.readers or "*" in self.readers


ReviewState = Literal["waiting", "approved", "refused"]

CellBox = tuple[int, int, int, int]
"""Rectangle of cells: column and row of its lower-left cell, width, height."""


class ConfirmedPlaces(msgspec.Struct, frozen=True):
    """Places that a robot has found changed, and that a proposed version of a map therefore changes.

    Parameters
    ----------
    robot : str
        Id of the robot. Its user is the author of the proposal.
    left, new : tuple of (float, float)
        Centres x, y of the places where something stood, and where something is new, in the map frame [m].
    """

    robot: str
    left: tuple[tuple[float, float], ...] = ()
    new: tuple[tuple[float, float], ...] = ()


class ProposedChange(msgspec.Struct, frozen=True):
    """Cells that differ between a proposed version of a map and the version that it was made from.

    A cell that was unknown and is free or occupied now counts as ``known`` too. ``rectangles`` cover the cells that
    changed; they are in cells of the proposed grid. ``confirmed`` are the places that a robot has found; None if the
    version is not the proposal of a robot.
    """

    occupied: int = 0
    free: int = 0
    known: int = 0
    unknown: int = 0
    rectangles: tuple[CellBox, ...] = ()
    confirmed: ConfirmedPlaces | None = None


class MapReview(msgspec.Struct, frozen=True):
    """A version of a map that waits beside the current one until it is approved or refused.

    Parameters
    ----------
    number : int
        Ascending number among the changes of the map, with gaps.
    version, base : str
        The proposed version, and the version that it was made from.
    created : float
        Time of the proposal [s since the epoch].
    author, message : str
        User who proposed it, and why.
    files : dict of str to MapFile
        Its files; empty once the review is closed.
    change : ProposedChange
        Difference from ``base``.
    keeps_zones : bool
        Whether it has the zones of the map, and follows their changes while it waits.
    state : str
        ``waiting``, ``approved`` or ``refused``.
    closed, closed_by, reason : optional
        When it was approved or refused [s since the epoch], by which user, and why.
    """

    number: int
    version: str
    base: str
    created: float
    author: str
    message: str = ""
    files: dict[str, MapFile] = {}
    change: ProposedChange = ProposedChange()
    state: ReviewState = "waiting"
    closed: float | None = None
    closed_by: str = ""
    reason: str = ""
    keeps_zones: bool = False

    @property
    def waits(self) -> bool:
        """Whether it is neither approved nor refused."""
        return self.state == "waiting"


class Publication(msgspec.Struct, frozen=True):
    """The metadata of a publication.

    Parameters
    ----------
    map, author : str
        Ids of the map and of the user who publishes it.
    created : float
        Time of the publication [s since the epoch].
    message : str
        Description of the change.
    owner : str, optional
        Owner of the map; the author by default.
    readers, description : optional
        None leaves them unchanged.
    if_match : str, optional
        Publish only if this is the current version.
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
    """A robot, as its user describes it in a JSON file.

    ``initial_pose`` is x [m], y [m], yaw [rad] in the map frame; ``cores`` is the decimal size of its container;
    ``properties`` is any JSON object, stored unread; ``labels`` are required of the machine of its container;
    ``shares`` are not part of the file, nor is ``since``, the time at which the robot was registered [s since the
    epoch]: what is older is of a former robot of the id. The URDF is stored separately.
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
    shares: tuple[Share, ...] = ()
    since: float = 0.0


class PlanRecord(msgspec.Struct, frozen=True):
    """A plan. ``poses`` holds the (n, 7) float64 array, little-endian, row by row.

    ``parameters`` are the planner's. ``origin`` is ``computed``; ``reused``, a stored plan; ``stitched``, a
    stored plan with computed ends; or ``given`` by a program, whose numbers are not verified. The *head* of a plan is
    the record without poses (empty bytes).
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
    """A stored plan that passes near two places: its head, and the index of its waypoint nearest to each."""

    head: PlanRecord
    first: int
    last: int


class PlanPart(msgspec.Struct, frozen=True):
    """A segment of a plan that is stored as a separate entry, which any number of plans share.

    ``first`` is the index of its first waypoint in the plan, ``count`` its number of waypoints, ``plans`` the number of
    references from plans.
    """

    entry: str
    first: int
    count: int
    plans: int


class PlanStatistics(msgspec.Struct, frozen=True):
    """Size of stored plans.

    ``waypoints`` counts the waypoints of all plans, ``kept`` those that are stored after de-duplication, ``entries``
    the shared segments; ``bytes`` is the size of plans and entries, without indexes.
    """

    plans: int = 0
    waypoints: int = 0
    kept: int = 0
    entries: int = 0
    bytes: int = 0


class CloneCheckpoint(msgspec.Struct, frozen=True):
    """State from which a clone continues in another container: the bytes that each node wrote, and the time saved."""

    user: str
    robot: str
    nodes: dict[str, bytes]
    saved: float


class CloneLogChange(msgspec.Struct, frozen=True):
    """Change of the log of a clone, which is stored together with a checkpoint.

    Parameters
    ----------
    log : str
        Name of the log; a clone may have logs of several names.
    entries : dict of int to bytes
        Entries to add, by their numbers. Entries of the same numbers are replaced.
    obsolete : list of int
        Numbers of entries to remove.
    """

    log: str
    entries: dict[int, bytes] = {}
    obsolete: list[int] = []


class MapTask(msgspec.Struct, frozen=True):
    """A task of a user on a map."""

    user: str
    map: str
    task: Task

    @property
    def key(self) -> tuple[str, str, str]:
        """User, map and id."""
        return self.user, self.map, self.task.id

    def changed_meanwhile(self) -> Conflict:
        """Return the error of a task that another process changed first."""
        return Conflict(f"task {self.task.id!r} has been changed meanwhile: read it again and retry")


class Lease(msgspec.Struct, frozen=True):
    """A lease, which holds no time: a candidate measures by its own clock for how long a lease has not changed.

    Parameters
    ----------
    name : str
        Name of the lease.
    holder : str
        Process that holds the lease; empty if nobody does.
    epoch : int
        Number of times that the lease was taken; it never decreases.
    beat : int
        Number of times that the holder has renewed the lease in this epoch.
    """

    name: str
    holder: str = ""
    epoch: int = 0
    beat: int = 0


def check_lease(lease: Lease, instead_of: Lease) -> None:
    """Check a change of a lease.

    Raises
    ------
    InvalidInput
        The name or the holder is not valid, or the change goes back.
    """
    check_name("lease", lease.name)
    if len(lease.holder) > LONGEST_HOLDER:
        raise InvalidInput(f"the holder of lease {lease.name!r} has more than {LONGEST_HOLDER} characters")
    if lease.name != instead_of.name or (lease.epoch, lease.beat) <= (instead_of.epoch, instead_of.beat):
        raise InvalidInput(f"lease {lease.name!r} would go back: its epoch and beat only grow")
