"""MAVLink 2 by pymavlink: its messages, and a parser that keeps what is signed apart from what is not."""

import os
from typing import Any

from ppaas.clock import epoch
from ppaas.distribution import check_versions, install_hint
from ppaas.errors import Unavailable

os.environ["MAVLINK20"] = "1"  # else pymavlink's other modules may fall back to MAVLink 1, which lacks messages

try:
    from pymavlink.dialects.v20 import ardupilotmega as mavlink
except ModuleNotFoundError as missing:
    raise Unavailable(f"vehicles with MAVLink need the extra mavlink: {install_hint('mavlink')}") from missing

__all__ = ["COMPONENT", "Parser", "check_installed", "mavlink"]

SIGNING_EPOCH = 1_420_070_400
"""Beginning of the time of signatures, 2015-01-01 [s since the epoch]; it counts steps of 10 µs."""

COMPONENT = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
"""Component of this station: so answers to it differ from answers to QGroundControl, if both have the same number."""

FORGED = "Invalid signature"
"""Reason of pymavlink for a message that is not signed with the key, or that was sent before."""


def check_installed() -> None:
    """Raise ``Unavailable`` if pymavlink is older than tried."""
    check_versions("mavlink")


class Parser(mavlink.MAVLink):  # type: ignore[misc]
    """Reads messages from bytes, and writes them.

    A message that is not signed with the key leaves what is known of its sender as it was.

    Parameters
    ----------
    system : int
        Number of this station.
    key : bytes, optional
        Key of 32 bytes with which messages are signed, and must be.

    Attributes
    ----------
    forged : int
        Number of messages that were not signed with the key.
    """

    def __init__(self, system: int, key: bytes | None = None) -> None:
        super().__init__(None, srcSystem=system, srcComponent=COMPONENT)
        self.robust_parsing = True
        self.seq: int = 0
        self.forged = 0
        if key is not None:
            self.signing.secret_key = key
            self.signing.sign_outgoing = True
            self.signing.timestamp = round((epoch() - SIGNING_EPOCH) * 1e5)

    def read(self, data: bytes) -> list[Any]:
        """Return the messages that are complete with these bytes; what is no message is left out."""
        found = []
        for message in self.parse_buffer(data) or ():
            if message.get_type() != "BAD_DATA":
                found.append(message)
            elif message.reason == FORGED:
                self.forged += 1
        return found

    def write(self, message: Any) -> bytes:
        """Return the bytes of a message, with the next number of this station."""
        data: bytes = message.pack(self)
        self.seq = (self.seq + 1) % 256
        return data

    def check_signature(self, msgbuf: bytearray, srcSystem: int, srcComponent: int) -> bool:  # noqa: N803
        """Return whether a message is signed with the key, and newer than the last one of its sender."""
        times = self.signing.stream_timestamps
        before = dict(times)
        good: bool = super().check_signature(msgbuf, srcSystem, srcComponent)
        if not good:
            times.clear()
            times.update(before)
        return good
