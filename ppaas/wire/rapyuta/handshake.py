"""Handshake: the request of a robot to the master for the address of its WebSocket, and the login in that address.

Source: ``RobotResource`` and ``RobotWebSocketProtocol`` in ``rce/comm/server.py``; ``rce/comm/_version.py``.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass

from ppaas.errors import InvalidInput
from ppaas.wire.rapyuta.tags import check_tag

OLDEST, NEWEST = "20130415", "20130902"
"""Oldest and newest version of clients. Versions compare as strings."""

Query = Sequence[tuple[str, str]]
"""Parameters of a query, by name and value, in order and with repetitions."""

DIGEST_LENGTH = 64
"""Length of a SHA-256 hash in hexadecimal digits."""

JSON = "application/json; charset=utf-8"
TEXT = "text/plain; charset=utf-8"


@dataclass(frozen=True, slots=True)
class MasterAnswer:
    """HTTP answer of the master: status, type and text of the body."""

    status: int
    media_type: str
    body: str


@dataclass(frozen=True, slots=True)
class RobotLogin:
    """Login of a robot: user, robot, and the secret, a SHA-256 hash of the password in hexadecimal digits."""

    user: str
    robot: str
    password: str


def answer_master(query: Query, url: str) -> MasterAnswer:
    """Return the master's answer to ``GET /?userID=U&version=V``.

    Parameters
    ----------
    query : sequence of (str, str)
        Query of the request.
    url : str
        Address of the WebSocket for robots.

    Returns
    -------
    MasterAnswer
        200 with the address, and the newest version if the client is older; 400 if a parameter is missing or repeated;
        410 if the version is too old, 501 if it is too new.
    """
    try:
        version, _ = _single(query, "version", "userID")
    except InvalidInput as error:
        return MasterAnswer(400, TEXT, str(error))
    if version < OLDEST:
        return MasterAnswer(410, TEXT, f"Client version is insufficient. Minimal version is '{OLDEST}'.")
    if version > NEWEST:
        return MasterAnswer(501, TEXT, f"Client version is too new. Newest version is '{NEWEST}'.")
    newer = {} if version == NEWEST else {"current": NEWEST}
    return MasterAnswer(200, JSON, json.dumps({"url": url, **newer}))


def parse_login(query: Query) -> RobotLogin:
    """Return the login in the query of a WebSocket's address, ``?userID=U&robotID=R&password=HASH``.

    Raises
    ------
    InvalidInput
        A parameter is missing, repeated or empty, or the id of the robot is not a tag.
    """
    user, robot, password = _single(query, "userID", "robotID", "password")
    return RobotLogin(user, check_tag("robotID", robot), password)


def is_digest(password: str) -> bool:
    """Return whether a secret has the form of a SHA-256 hash in hexadecimal digits."""
    return len(password) == DIGEST_LENGTH and set(password.lower()) <= set("0123456789abcdef")


def _single(query: Query, *names: str) -> list[str]:
    """Return the values of parameters that must be given once each."""
    given = {name: [value for key, value in query if key == name] for name in names}
    for name, values in given.items():
        if not any(values):
            raise InvalidInput(f"Request is missing parameter: '{name}'")
        if len(values) != 1:
            raise InvalidInput(f"Parameter '{name}' has to be unique in request.")
    return [values[0] for values in given.values()]
