"""Without its packages, the port of viewers is refused with what to install."""

import pytest

from ppaas import distribution
from ppaas.errors import InvalidInput, Unavailable
from ppaas.wire.foxglove import installed


def test_the_packages_are_installed_here() -> None:
    installed.check_installed()


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installed, "PACKAGES", ("foxglove", "no_such_package"))
    with pytest.raises(InvalidInput, match=r"pip install '\.\[cloud,foxglove\]'"):
        installed.check_installed()


def test_an_old_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    version = distribution.version
    monkeypatch.setattr(distribution, "version", lambda name: "0.1" if name == "foxglove-sdk" else version(name))
    with pytest.raises(Unavailable, match=r"foxglove-sdk 0\.1 \(needed: >="):
        installed.check_installed()
