"""Without its packages, the port of viewers is refused with what to install."""

import pytest

from ppaas.errors import InvalidInput
from ppaas.wire.foxglove import installed


def test_the_packages_are_installed_here() -> None:
    installed.check_installed()


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installed, "PACKAGES", ("foxglove", "no_such_package"))
    with pytest.raises(InvalidInput, match=r"pip install '\.\[cloud,foxglove\]'"):
        installed.check_installed()
