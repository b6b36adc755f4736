"""Every error a user can meet, as one tree.

::

    PPaaSError
    ├── InvalidInput                what was sent cannot be taken
    │   ├── MalformedMessage        not JSON, not of the message's type, not finite
    │   ├── MessageTooLarge
    │   ├── UnknownType             no such ROS message or service type
    │   ├── InvalidMap              a map file or an occupancy grid that cannot be one
    │   ├── InvalidUrdf             a robot's URDF that cannot be one
    │   └── InvalidParameter
    ├── NotFound                    what was named does not exist: a map, a robot, a planner, a topic …
    ├── Conflict                    it exists already, or is in use
    ├── NotAuthenticated            who are you?
    ├── NotPermitted                we know who you are, and no
    ├── QuotaExceeded               a limit of this user or machine, named
    ├── Unavailable                 try again: no capacity, a dead store, a container that was lost
    │   ├── Queued                  it waits for its turn, as was asked for
    │   └── Idle                    let go, since nothing was said: try again when there is something to say
    ├── TransformError              no path between two frames, or not at that time
    └── PlanningError               the failure codes of Nav2's ComputePathToPose, 201–208
        ├── InvalidPlanner          201
        ├── PlanTransformError      202
        ├── StartOutsideMap         203
        ├── GoalOutsideMap          204
        ├── StartOccupied           205
        ├── GoalOccupied            206
        ├── PlanTimeout             207
        ├── NoValidPath             208
        └── PlanCancelled           the caller said so; no code of Nav2's

Each has a ``slug``, stable and machine-readable: the problem type in HTTP answers, and the prefix of
the text in a rosbridge ``status``.
"""

from typing import ClassVar


class PPaaSError(Exception):
    """Base of all errors that are told to users."""

    slug: ClassVar[str] = "error"


class InvalidInput(PPaaSError):
    """What was sent cannot be taken."""

    slug = "invalid-input"


class MalformedMessage(InvalidInput):
    """Not JSON, not of the message's type, or not finite where it must be."""

    slug = "malformed-message"


class MessageTooLarge(InvalidInput):
    """A frame or an upload is over its limit."""

    slug = "message-too-large"


class UnknownType(InvalidInput):
    """No message or service type of that name is known."""

    slug = "unknown-type"


class InvalidMap(InvalidInput):
    """A map file or an occupancy grid that cannot be one."""

    slug = "invalid-map"


class InvalidUrdf(InvalidInput):
    """A robot's URDF that cannot be one."""

    slug = "invalid-urdf"


class InvalidParameter(InvalidInput):
    """A parameter is unknown, of the wrong type or out of range."""

    slug = "invalid-parameter"


class NotFound(PPaaSError):
    """What was named does not exist.

    Parameters
    ----------
    kind : str
        The noun: ``"map"``, ``"robot"``, ``"planner"`` …
    name : str
        What was asked for.
    known : iterable of str, optional
        The valid names, if they are few and may be told.
    """

    slug = "not-found"

    def __init__(self, kind: str, name: str, known: "tuple[str, ...] | list[str]" = ()) -> None:
        self.kind = kind
        self.name = name
        hint = f"; known: {', '.join(sorted(known))}" if known else ""
        super().__init__(f"unknown {kind} {name!r}{hint}")


class Conflict(PPaaSError):
    """It exists already, or is in use."""

    slug = "conflict"


class NotAuthenticated(PPaaSError):
    """No valid password or token was given."""

    slug = "not-authenticated"


class NotPermitted(PPaaSError):
    """The user is known and may not do this."""

    slug = "not-permitted"


class QuotaExceeded(PPaaSError):
    """A limit of this user or machine was reached; the text names it.

    Parameters
    ----------
    text : str
        Which limit, and what to do.
    retry_after : float, optional
        Time after which the same may be asked again [s], where time alone helps.
    """

    slug = "quota-exceeded"
    retry_after: float | None = None

    def __init__(self, text: str, *, retry_after: float | None = None) -> None:
        self.retry_after = retry_after
        super().__init__(text)


class Unavailable(PPaaSError):
    """Nothing is wrong with the request; it can be tried again."""

    slug = "unavailable"


class Idle(Unavailable):
    """Nobody said anything for long, and there was no goal: come again when there is something to say."""

    slug = "idle"


class Queued(Unavailable):
    """It waits for its turn, as was asked for.

    Parameters
    ----------
    position : int
        In the queue, the first being 1.
    """

    slug = "queued"
    position: int = 0

    def __init__(self, position: int) -> None:
        self.position = position
        super().__init__(f"it has position {position} in the queue: ask the same again to stay there")


class TransformError(PPaaSError):
    """Two frames are not connected, or not at the time asked for."""

    slug = "transform"


class PlanningError(PPaaSError):
    """No plan. ``code`` is that of Nav2's ``ComputePathToPose`` result."""

    slug = "planning-failed"
    code: ClassVar[int] = 0


class InvalidPlanner(PlanningError):
    """The planner is not known, or cannot plan on this kind of map."""

    slug = "invalid-planner"
    code = 201


class PlanTransformError(PlanningError):
    """Start or goal could not be transformed into the frame of the map."""

    slug = "plan-transform"
    code = 202


class StartOutsideMap(PlanningError):
    """The start lies outside the map."""

    slug = "start-outside-map"
    code = 203


class GoalOutsideMap(PlanningError):
    """The goal lies outside the map."""

    slug = "goal-outside-map"
    code = 204


class StartOccupied(PlanningError):
    """The robot would be in collision at the start."""

    slug = "start-occupied"
    code = 205


class GoalOccupied(PlanningError):
    """The robot would be in collision at the goal, and within the tolerance around it."""

    slug = "goal-occupied"
    code = 206


class PlanTimeout(PlanningError):
    """The deadline passed."""

    slug = "plan-timeout"
    code = 207


class NoValidPath(PlanningError):
    """Start and goal are not connected."""

    slug = "no-valid-path"
    code = 208


class PlanCancelled(PlanningError):
    """The cancel checker said so."""

    slug = "plan-cancelled"


def _tree(root: type[PPaaSError]) -> dict[str, type[PPaaSError]]:
    found = {root.slug: root}
    for child in root.__subclasses__():
        found |= _tree(child)
    return found


def rebuild(slug: str, text: str) -> PPaaSError:
    """Return the error that another process told of by its slug and text."""
    cls = _tree(PPaaSError).get(slug, PPaaSError)
    error = cls.__new__(cls)
    Exception.__init__(error, text)
    return error
