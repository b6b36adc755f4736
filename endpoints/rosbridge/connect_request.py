"""Connect request of a client: the query in the address of its WebSocket."""

from collections.abc import Mapping
from dataclasses import dataclass

from engine.protocols.session_frames import SessionClient
from engine.rights.globs import split_address
from engine.rights.roles import Role, role_of
from engine.sessions.namespaces import parse_namespace
from ppaas.errors import InvalidParameter
from ppaas.wire.resumption import RESUME, SESSION, ResumptionPoint, parse_name, parse_point


@dataclass(frozen=True, slots=True)
class ConnectRequest:
    """Parameters of a client's connection to a robot.

    Parameters
    ----------
    robot : str
        Id of the robot; empty if the client names none, which the only robot of its user need not be.
    owner : str
        User to whom the robot belongs; empty for the user of the client.
    role : {"robot", "operator"}
        Role of the client.
    session : str, optional
        Name of the client's session; without one, the session ends with the socket.
    resume : ResumptionPoint, optional
        Point at which the client resumes this session.
    counts : bool
        Whether the client counts frames: it resumes exactly at that point, or starts a new session.
    hold : bool
        Whether the place is opened and kept open for this client.
    status : bool
        Whether errors are reported to the client from the start.
    queue : bool
        Whether the client waits in the queue if no container is available now, and is notified of its position.
    namespace : str, optional
        Namespace of the robot's names in the client's software.
    compact : bool
        Whether velocities are sent to the client as compact frames.
    png : bool
        Whether the client reads the operation ``png`` if it asks for it.
    """

    robot: str
    role: Role = "robot"
    session: str | None = None
    resume: ResumptionPoint | None = None
    counts: bool = False
    hold: bool = True
    status: bool = False
    queue: bool = False
    owner: str = ""
    namespace: str | None = None
    compact: bool = False
    png: bool = True

    def client(self, user: str) -> SessionClient:
        """Return the client of a session, which is this user."""
        return SessionClient(user, self.owner or user, self.robot, self.role, self.session)


def parse_connect_request(query: Mapping[str, str]) -> ConnectRequest:
    """Return the connect request in the query of an address.

    Raises
    ------
    InvalidParameter
        A parameter is invalid.
    """
    role = role_of(query.get("role", "robot"))
    robot = query.get("robot")
    if robot == "":
        raise InvalidParameter("the parameter 'robot' is empty: open ws://HOST/?robot=ID")
    owner, robot = split_address(robot or "", "")
    if owner and not robot:
        raise InvalidParameter(f"the parameter 'robot' names no robot of {owner[:64]!r}: give OWNER:ID")
    session, resume = query.get(SESSION), query.get(RESUME)
    if resume is not None and session is None:
        raise InvalidParameter(f"{RESUME!r} needs the name of a session: also give 'session'")
    hold = query.get("hold", "1")
    if hold not in ("0", "1"):
        raise InvalidParameter(f"hold must be 0 or 1, not {hold[:32]!r}")
    if hold == "0" and role == "robot":
        raise InvalidParameter("hold=0 is for operators only: a robot always holds its place")
    return ConnectRequest(
        robot=robot,
        owner=owner,
        role=role,
        session=parse_name(session) if session is not None else None,
        resume=parse_point(resume) if resume is not None else None,
        counts=resume is not None,
        hold=hold == "1",
        status=query.get("status") == "1",
        queue=query.get("queue") == "1",
        namespace=parse_namespace(query["namespace"]) if "namespace" in query else None,
        compact=query.get("compact") == "1",
    )
