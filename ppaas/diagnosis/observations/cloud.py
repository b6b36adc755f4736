"""Facts about a cloud, as a client sees it."""

import msgspec


class MachineFacts(msgspec.Struct, kw_only=True, frozen=True):
    """Machine of a cloud: its state, and its size and what it has given [cores]."""

    name: str
    state: str
    capacity: float
    given: float


class RobotLine(msgspec.Struct, kw_only=True, frozen=True):
    """Robot in the list of a user's robots: its level, and the first finding about it."""

    name: str
    connected: bool
    level: str
    text: str


class CloudFacts(msgspec.Struct, kw_only=True, frozen=True):
    """What a client finds out about a cloud.

    Parameters
    ----------
    url : str
    problem : str
        Reason for which the cloud cannot be reached; empty if it answers.
    round_trip : float
        Time of a request [s].
    version, own_version : str
        Versions of the cloud and of this program.
    ahead : float
        Time by which the clock of this computer is ahead of the cloud's, as exactly as half a round trip [s].
    user : str
        Owner of the token; empty if there is none, or it is not valid.
    token_problem : str
        Reason for which the token is of no use.
    away : dict of str to str
        Stores that do not answer, with the reason if the user may see it.
    disk : str
        State of the disk: ``ok``, or what is wrong.
    plans_waiting : int
        Plans that wait for a store.
    machines : list of MachineFacts, optional
        None if the user may not see them.
    robots : list of RobotLine
    """

    url: str
    problem: str = ""
    round_trip: float = 0.0
    version: str = ""
    own_version: str = ""
    ahead: float = 0.0
    user: str = ""
    token_problem: str = ""
    away: dict[str, str] = {}
    disk: str = "ok"
    plans_waiting: int = 0
    machines: list[MachineFacts] | None = None
    robots: list[RobotLine] = []
