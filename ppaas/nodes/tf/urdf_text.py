"""URDF of a robot as it was stored, for the topic and the parameter ``robot_description``."""

import zlib
from dataclasses import dataclass

from ppaas.messages.base.std_msgs import String


@dataclass(frozen=True, slots=True)
class UrdfText:
    """URDF that becomes text only when a client asks for it: compressed, it takes a tenth of the memory.

    Parameters
    ----------
    compressed : bytes
        The document in UTF-8, compressed by zlib.
    """

    compressed: bytes

    @classmethod
    def of(cls, document: bytes) -> "UrdfText":
        """Return a URDF from its document in UTF-8."""
        return cls(zlib.compress(document))

    def text(self) -> str:
        """Return the document, without a byte order mark."""
        return zlib.decompress(self.compressed).decode("utf-8-sig")

    def to_message(self) -> String:
        """Return ``std_msgs/String``."""
        return String(self.text())
