"""Options of ``ppaas bridge mavlink``."""

import argparse
import math
import sys
from pathlib import Path

import pytest

from ppaas import distribution
from ppaas.errors import InvalidInput, InvalidMap
from robots.bridges.cli import mavlink
from robots.cli.main import main

NEEDED = ["--robot", "r", "--vehicle", "udpin:0.0.0.0:14550"]


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    mavlink.configure(parser)
    return parser.parse_args([*NEEDED, *words])


def test_without_options_the_only_vehicle_is_taken_and_neither_armed_nor_signed() -> None:
    options = mavlink.options_of(parsed())
    assert (options.station.system, options.station.station, options.station.key) == (None, 255, None)
    assert options.anchor is None and not options.arm


def test_options_are_read(tmp_path: Path) -> None:
    key = tmp_path / "key"
    key.write_text("ab" * 32)
    words = ["--system", "7", "--station", "250", "--anchor=-33.9,151.2,90", "--arm", "--signing-key-file", str(key)]
    options = mavlink.options_of(parsed(*words))
    assert (options.station.system, options.station.station) == (7, 250)
    assert options.station.key == b"\xab" * 32 and options.arm
    anchor = options.anchor
    assert anchor is not None
    assert (anchor.latitude, anchor.longitude, anchor.yaw) == pytest.approx((-33.9, 151.2, math.pi / 2.0))


@pytest.mark.parametrize("words", [["--system", "0"], ["--system", "256"], ["--anchor=1"], ["--anchor=1,2,3,4"]])
def test_options_out_of_range_are_refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        parsed(*words)
    assert words[0].split("=")[0] in capsys.readouterr().err


def test_what_is_no_address_no_place_and_no_key_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no address of a vehicle: 'serial'"):
        mavlink.options_of(parsed("--vehicle", "serial"))
    with pytest.raises(InvalidMap, match="latitude"):
        mavlink.options_of(parsed("--anchor=91,0"))
    with pytest.raises(InvalidInput, match="cannot read the key"):
        mavlink.options_of(parsed("--signing-key-file", str(tmp_path / "none")))


def test_pymavlink_is_named_if_it_is_not_installed_or_too_old(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    version = distribution.version
    with monkeypatch.context() as older:
        older.setattr(distribution, "version", lambda name: "2.4.9" if name == "pymavlink" else version(name))
        assert main(["bridge", "mavlink", *NEEDED, "--token", "t"]) == 1
    assert "pymavlink 2.4.9 (needed: >=" in capsys.readouterr().err
    monkeypatch.delitem(sys.modules, "robots.bridges.mavlink.dialect", raising=False)
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    assert main(["bridge", "mavlink", *NEEDED, "--token", "t"]) == 1
    assert "pip install '.[mavlink]'" in capsys.readouterr().err
