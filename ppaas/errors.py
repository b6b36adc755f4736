"""All errors that are reported to users, as one tree.

::

    PPaaSError
    ├── InvalidInput                the request or its data is invalid
    │   ├── MalformedMessage        not JSON, not of the expected type, or not finite
    │   ├── MessageTooLarge         larger than the limit for frames or uploads
    │   ├── UnknownType             unknown ROS message or service type
    │   ├── InvalidMap              invalid map file, occupancy grid or voxel grid
    │   ├── InvalidUrdf             invalid robot description (URDF)
    │   ├── InvalidZones            invalid zones of a map
    │   ├── InvalidBuilding         invalid record of a building
    │   ├── InvalidGraph            invalid pose graph, or file of one
    │   └── InvalidParameter        unknown, of the wrong type, or out of range
    │       └── InvalidRobot        parts of a robot file that its clone refuses
    ├── NotFound                    unknown map, robot, planner, topic …
    ├── Conflict                    the resource exists already, or is in use
    │   └── MapsNotMerged           two maps do not overlap, or fit in several ways
    ├── NotAuthenticated            no valid password or token
    ├── NotPermitted                authenticated, but not allowed to do this
    ├── QuotaExceeded               a limit of the user or the machine is reached
    │   └── TooManyAttempts         too many failed logins
    ├── Unavailable                 temporary: no capacity, a store or a container failed; try again
    │   ├── Damaged                 a stored record that cannot be read
    │   ├── Starting                kernels are being compiled, as on the first start on a computer
    │   ├── Queued                  waiting for capacity, as requested
    │   └── Idle                    released after a time without messages and goals
    ├── TransformError              two frames are not connected, or not at that time
    └── PlanningError               no path was planned; codes of Nav2's ComputePathToPose
        ├── InvalidPlanner          201
        ├── PlanTransformError      202
        ├── StartOutsideMap         203
        ├── GoalOutsideMap          204
        ├── StartOccupied           205
        ├── GoalOccupied            206
        ├── PlanTimeout             207
        ├── NoValidPath             208
        └── PlanCancelled           no code in Nav2

Each class has a stable, machine-readable ``slug``. It is the problem type in HTTP answers (RFC 9457) and the prefix of
the text of a rosbridge ``status``.
"""

from collections.abc import Iterable, Sequence
from typing import ClassVar, NamedTuple


def listed(names: Iterable[str]) -> str:
    """Return names as a list in an error text; one that could be taken for something else is quoted."""
    return ", ".join(name if name.isprintable() and not {",", " "} & set(name) else repr(name) for name in names)


class PPaaSError(Exception):
    """Base of all errors that are reported to users."""

    slug: ClassVar[str] = "error"

    @property
    def public(self) -> str:
        """Text for clients; the text of the error itself is for operators, who read it in the log."""
        return str(self)


class InvalidInput(PPaaSError):
    """The request or its data is invalid."""

    slug = "invalid-input"


class MalformedMessage(InvalidInput):
    """The data is not JSON, not of the expected message type, or has a number that is not finite."""

    slug = "malformed-message"


class MessageTooLarge(InvalidInput):
    """A frame or an upload is larger than its limit."""

    slug = "message-too-large"


class UnknownType(InvalidInput):
    """No ROS message or service type of that name is known."""

    slug = "unknown-type"


class InvalidMap(InvalidInput):
    """A map file, an occupancy grid or a voxel grid is invalid."""

    slug = "invalid-map"


class InvalidUrdf(InvalidInput):
    """The URDF of a robot is invalid."""

    slug = "invalid-urdf"


class ZoneFault(NamedTuple):
    """What is wrong with a zone.

    Parameters
    ----------
    zone : str
        Name of the zone; the number of its feature if it has none.
    text : str
        What is wrong, and what to do.
    place : tuple of float, optional
        Where it is wrong: x, y in the frame of the map [m].
    """

    zone: str
    text: str
    place: tuple[float, float] | None = None


class InvalidZones(InvalidInput):
    """The zones of a map are invalid; ``faults`` are what is wrong with which zone, where that is known."""

    slug = "invalid-zones"
    faults: tuple[ZoneFault, ...] = ()

    def __init__(self, text: str, faults: Sequence[ZoneFault] = ()) -> None:
        super().__init__(text)
        self.faults = tuple(faults)


class InvalidBuilding(InvalidInput):
    """The record of a building is invalid."""

    slug = "invalid-building"


class InvalidGraph(InvalidInput):
    """A pose graph or the text of one is invalid."""

    slug = "invalid-graph"


class InvalidParameter(InvalidInput):
    """A parameter is unknown, of the wrong type or out of range."""

    slug = "invalid-parameter"


class RobotFault(NamedTuple):
    """Part of a robot file that its clone refuses.

    ``parameter`` is its path in the file, such as ``parameters.dwa.sim_time``; empty if no single part is at fault.
    ``text`` is why it is refused, in the words of the clone.
    """

    parameter: str
    text: str


class InvalidRobot(InvalidParameter):
    """The clone of a robot would refuse its file; ``faults`` are all that were found."""

    slug = "invalid-robot"
    faults: tuple[RobotFault, ...] = ()

    def __init__(self, faults: Sequence[RobotFault]) -> None:
        self.faults = tuple(faults)
        parts = [f"{fault.parameter or 'the robot file'}: {fault.text}" for fault in faults]
        if len(parts) > 1:
            parts = [f"({number}) {part}" for number, part in enumerate(parts, start=1)]
        each = "correct or remove" if len(parts) == 1 else f"correct or remove each of {len(parts)}:"
        super().__init__(f"{each} {'; '.join(parts)}")


class NotFound(PPaaSError):
    """No resource of that kind and name exists.

    Parameters
    ----------
    kind : str
        Noun for the resource: ``"map"``, ``"robot"``, ``"planner"`` …
    name : str
        The requested name.
    known : iterable of str, optional
        The existing names, if they are few and not secret.
    advice : str, optional
        What to do.
    """

    slug = "not-found"

    def __init__(self, kind: str, name: str, known: "tuple[str, ...] | list[str]" = (), *, advice: str = "") -> None:
        self.kind = kind
        self.name = name
        hint = f"; known: {listed(sorted(known))}" if known else ""
        super().__init__(f"unknown {kind} {name!r}{hint}{advice and f'; {advice}'}")


class Conflict(PPaaSError):
    """The resource exists already, or is in use."""

    slug = "conflict"


class MapsNotMerged(Conflict):
    """Two maps do not overlap enough, contradict each other, or fit in more than one way."""

    slug = "maps-not-merged"


class NotAuthenticated(PPaaSError):
    """The request has no valid password or token."""

    slug = "not-authenticated"


class NotPermitted(PPaaSError):
    """The user is authenticated, but not allowed to do this."""

    slug = "not-permitted"


class QuotaExceeded(PPaaSError):
    """A limit of the user or the machine is reached.

    ``text`` names the limit, and what to do. ``retry_after`` is the time until the same request can succeed [s]; None
    if waiting alone does not help.
    """

    slug = "quota-exceeded"
    retry_after: float | None = None

    def __init__(self, text: str, *, retry_after: float | None = None) -> None:
        self.retry_after = retry_after
        super().__init__(text)


class TooManyAttempts(QuotaExceeded):
    """Too many logins failed: the next attempt has to wait."""

    slug = "too-many-attempts"


class Unavailable(PPaaSError):
    """The request is valid but cannot be served now; try again later.

    Parameters
    ----------
    text : str
        Description of the failure, and a remedy.
    public : str, optional
        Text for clients, if the text names a file, an address or another secret of the server.
    """

    slug = "unavailable"
    _public: str | None = None

    def __init__(self, text: str, *, public: str | None = None) -> None:
        self._public = public
        super().__init__(text)

    @property
    def public(self) -> str:
        """Text for clients."""
        return str(self) if self._public is None else self._public


class Damaged(Unavailable):
    """A stored record that cannot be read: it is restored from a backup, or removed."""


class Starting(Unavailable):
    """The cloud or a planner is not ready yet, because kernels are being compiled; wait and try again.

    ``text`` says what is being compiled, and how far. ``retry_after`` is the time after which the same request may
    succeed [s]; None if it is not known.
    """

    slug = "starting"
    retry_after: float | None = None

    def __init__(self, text: str, *, retry_after: float | None = None) -> None:
        self.retry_after = retry_after
        super().__init__(text)


class Idle(Unavailable):
    """The session was released because it had no goal and its clients sent nothing for a long time; connect again."""

    slug = "idle"


class Queued(Unavailable):
    """The request waits in the queue for capacity, or for what ``why`` says, as its sender asked.

    Parameters
    ----------
    position : int
        Position in the queue, counted from 1.
    """

    slug = "queued"
    position: int = 0

    def __init__(self, position: int, why: str = "") -> None:
        self.position = position
        until = f" ({why})" if why else ""
        super().__init__(
            f"waiting at position {position} in the queue{until}: repeat the request to keep this position"
        )


class TransformError(PPaaSError):
    """Two frames are not connected, or not at the requested time."""

    slug = "transform"


class PlanningError(PPaaSError):
    """No path was planned. ``code`` is the ``error_code`` of Nav2's ``ComputePathToPose``; 0 where it has none."""

    slug = "planning-failed"
    code: ClassVar[int] = 0


class InvalidPlanner(PlanningError):
    """The planner is unknown, or cannot plan on this kind of map."""

    slug = "invalid-planner"
    code = 201


class PlanTransformError(PlanningError):
    """The start or the goal cannot be transformed into the frame of the map."""

    slug = "plan-transform"
    code = 202


class StartOutsideMap(PlanningError):
    """The start is outside the map."""

    slug = "start-outside-map"
    code = 203


class GoalOutsideMap(PlanningError):
    """The goal is outside the map."""

    slug = "goal-outside-map"
    code = 204


class StartOccupied(PlanningError):
    """The robot would be in collision at the start."""

    slug = "start-occupied"
    code = 205


class GoalOccupied(PlanningError):
    """The robot would be in collision at the goal and everywhere within the tolerance around it."""

    slug = "goal-occupied"
    code = 206


class PlanTimeout(PlanningError):
    """The planner did not finish within its time limit."""

    slug = "plan-timeout"
    code = 207


class NoValidPath(PlanningError):
    """No free path connects the start and the goal."""

    slug = "no-valid-path"
    code = 208


class PlanCancelled(PlanningError):
    """The caller cancelled planning."""

    slug = "plan-cancelled"


def _classes_by_slug(root: type[PPaaSError]) -> dict[str, type[PPaaSError]]:
    """Return a class and all its subclasses, by slug; a subclass without its own slug is left out."""
    found = {root.slug: root}
    for child in root.__subclasses__():
        found = _classes_by_slug(child) | found
    return found


def rebuild(slug: str, text: str) -> PPaaSError:
    """Return the error that another process reported, from its slug and text; a `PPaaSError` for an unknown slug."""
    cls = _classes_by_slug(PPaaSError).get(slug, PPaaSError)
    error = cls.__new__(cls)
    Exception.__init__(error, text)
    return error
