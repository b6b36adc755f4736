"""Versions of VDA 5050 that two sides share."""

import pytest

from ppaas.errors import NotFound
from ppaas.wire.vda5050.topics import Version, understand, version_of


@pytest.mark.parametrize(
    ("text", "version"),
    [
        ("2.0.0", Version.V2_0),
        ("2.0", Version.V2_0),
        ("2.1.0", Version.V2_1),
        ("2.7.1", Version.V2_1),
        ("v2", Version.V2_1),
        ("2", Version.V2_1),
        ("3.0.0-rc1", Version.V3_0),
        ("v3", Version.V3_0),
    ],
)
def test_the_nearest_version_is_spoken(text: str, version: Version) -> None:
    assert version_of(text) is version


@pytest.mark.parametrize("text", ["1.1.0", "4.0.0", "", "two", "2.", "99999.0"])
def test_unknown_versions_are_refused(text: str) -> None:
    with pytest.raises(NotFound, match=r"2\.0\.0, 2\.1\.0, 3\.0\.0"):
        version_of(text)


def test_minor_versions_understand_each_other() -> None:
    assert understand(Version.V2_0, "2.1.0")
    assert not understand(Version.V2_1, "3.0.0")
    assert not understand(Version.V2_1, "nothing")
