"""Check that the packages that messages of Foxglove need are installed."""

from importlib.util import find_spec
from typing import Final

from ppaas.errors import InvalidInput

PACKAGES: Final = ("foxglove", "rosbags")


def check_installed() -> None:
    """Raise ``InvalidInput`` unless the packages of the extra ``foxglove`` are installed."""
    if not all(find_spec(package) for package in PACKAGES):
        raise InvalidInput("viewers of Foxglove need the extra foxglove: pip install 'ppaas[cloud,foxglove]'")
