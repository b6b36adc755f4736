"""Connect request of a client: the query in the address of its WebSocket."""

from collections.abc import Mapping
from dataclasses import dataclass

from endpoints.rosbridge.roles import Role, role_of
from ppaas.errors import InvalidParameter
from ppaas.wire.resumption import RESUME, SESSION, ResumptionPoint, parse_name, parse_point


@dataclass(frozen=True, slots=True)
class ConnectRequest:
    """The robot whose place a client connects to, and how.

    Parameters
    ----------
    robot : str
        Whose place it is.
    role : {"robot", "operator"}
        As whom.
    session : str, optional
        Name of the client's session; without one, nothing is kept of the client when its socket is gone.
    resume : ResumptionPoint, optional
        How far the client got in that session.
    counts : bool
        The client counts frames: it resumes at that point or begins anew. One that does not takes what there is.
    hold : bool
        The place is opened for this client, and kept for it.
    status : bool
        Tell it of errors from the start.
    queue : bool
        It waits for its turn where there is no container for it now, and is told its position.
    """

    robot: str
    role: Role = "robot"
    session: str | None = None
    resume: ResumptionPoint | None = None
    counts: bool = False
    hold: bool = True
    status: bool = False
    queue: bool = False


def parse_connect_request(query: Mapping[str, str]) -> ConnectRequest:
    """Return the request that the query of an address spells.

    Raises
    ------
    InvalidParameter
        No robot is named, or something cannot be what it is given as.
    """
    role = role_of(query.get("role", "robot"))
    robot = query.get("robot", "")
    if not robot:
        raise InvalidParameter("no robot named: open ws://HOST/?robot=ID&token=TOKEN")
    session, resume = query.get(SESSION), query.get(RESUME)
    if resume is not None and session is None:
        raise InvalidParameter(f"{RESUME!r} needs the name of a session: give 'session' too")
    hold = query.get("hold", "1")
    if hold not in ("0", "1"):
        raise InvalidParameter(f"hold is 0 or 1, not {hold!r}")
    if hold == "0" and role == "robot":
        raise InvalidParameter("hold=0 is for operators: a robot always has a place")
    return ConnectRequest(
        robot=robot,
        role=role,
        session=parse_name(session) if session is not None else None,
        resume=parse_point(resume) if resume is not None else None,
        counts=resume is not None,
        hold=hold == "1",
        status=query.get("status") == "1",
        queue=query.get("queue") == "1",
    )
