"""The library mcap, as it is installed."""

import pytest

from ppaas import distribution
from ppaas.errors import Unavailable
from ppaas.recording.mcap_library import mcap_modules


def test_the_writer_and_its_records_are_returned() -> None:
    writer, records = mcap_modules()
    assert (writer.__name__, records.__name__) == ("mcap.writer", "mcap.records")


def test_a_library_that_cannot_flush_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    version = distribution.version
    monkeypatch.setattr(distribution, "version", lambda name: "1.4.0" if name == "mcap" else version(name))
    with pytest.raises(Unavailable, match=r"mcap 1\.4\.0 \(needed: >=1\.5\)"):
        mcap_modules()
