"""Check that the packages that messages of Foxglove need are installed."""

from importlib.util import find_spec
from typing import Final

from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput

PACKAGES: Final = ("foxglove", "rosbags")


def check_installed() -> None:
    """Raise ``InvalidInput`` unless the packages of the extra ``foxglove`` are installed, in versions that were tried.

    Raises
    ------
    Unavailable
        One of them is older than tried.
    """
    if not all(find_spec(package) for package in PACKAGES):
        raise InvalidInput(f"viewers of Foxglove need the extra foxglove: {install_hint('cloud', 'foxglove')}")
    check_versions("foxglove")
