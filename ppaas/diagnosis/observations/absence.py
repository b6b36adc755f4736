"""Facts about a robot that is not connected: what would stop it from connecting."""

import msgspec


class AbsenceFacts(msgspec.Struct, kw_only=True, frozen=True):
    """What the cloud knows of a robot without its messages.

    Parameters
    ----------
    robot : str
    agv : str
        Manufacturer and serial number of the AGV that the robot is by its file; empty for other robots.
    refusal : str
        Reason for which its last attempt to connect was refused; empty without one, or if it connected since.
    refused_ago : float
        Time since then [s].
    map_problem, quota_problem : str
        Reasons for which its map cannot be used, and for which its user may have no more containers; else empty.
    cores : float
        Size of its container [cores].
    free : tuple of float
        What each machine that accepts containers could give it [cores].
    """

    robot: str
    agv: str = ""
    refusal: str = ""
    refused_ago: float = 0.0
    map_problem: str = ""
    quota_problem: str = ""
    cores: float = 1.0
    free: tuple[float, ...] = ()
