"""Versions of VDA 5050, and which of them two sides share."""

import re
from enum import StrEnum

from ppaas.errors import NotFound


class Version(StrEnum):
    """Version of VDA 5050, spelled as in the header of a message."""

    V2_0 = "2.0.0"
    V2_1 = "2.1.0"
    V3_0 = "3.0.0"

    @property
    def major(self) -> int:
        """Major version: 2 or 3. Topics and most names of fields depend on it."""
        return int(self.value[0])

    @property
    def interface(self) -> str:
        """First level of topics, as the specification proposes it."""
        return "uagv" if self is not Version.V3_0 else "vda5050"


_FORM = re.compile(r"v?(\d{1,4})(?:\.(\d{1,4})(?:\.[\w.+-]{1,40})?)?")


def version_of(text: str) -> Version:
    """Return the version to speak with a side that names its own.

    Minor versions of one major version understand each other, so an unknown one counts as the newest known.

    Parameters
    ----------
    text : str
        Version as in a header (``2.1.0``), a topic (``v2``) or an option (``2.1``).

    Raises
    ------
    NotFound
        The major version is not known; 1 is not served.
    """
    form = _FORM.fullmatch(text)
    major, minor = (int(form[1]), form[2]) if form else (0, None)
    if major == 2:
        return Version.V2_0 if minor is not None and int(minor) == 0 else Version.V2_1
    if major == 3:
        return Version.V3_0
    raise NotFound("version of VDA 5050", text, [*Version])


def understand(own: Version, text: str) -> bool:
    """Return whether a message whose header names version ``text`` can be read by a side of version ``own``."""
    try:
        return version_of(text).major == own.major
    except NotFound:
        return False
