"""Settings and names of machines outlive the cloud process."""

import logging
from pathlib import Path

import pytest

from engine.control.administration import Administration, MachineRegistry
from engine.master.balancers.first_fit import FirstFit
from engine.master.events import RemovalRequested
from engine.master.master import Master
from engine.specs.machine_settings import MachineSettings
from engine.specs.start_state import READY
from ppaas.errors import InvalidInput, NotPermitted, Unavailable
from tests.support.engine.placing import joined

SETTINGS = MachineSettings({"zone": "a"}, max_containers=3, max_memory=1 << 30, draining=True)


def started(file: Path) -> tuple[Master, Administration]:
    master = Master(FirstFit())

    def cut_off(request: RemovalRequested) -> None:
        master.handle(request)

    administration = Administration(master, lambda orders: None, cut_off, lambda machine: None, lambda: READY)
    administration.keep_in(file)
    return master, administration


async def test_settings_hold_for_the_next_cloud_process(tmp_path: Path) -> None:
    file = tmp_path / "data" / "settings.json"
    master, administration = started(file)
    for name in ("m1", "m2", "m3"):
        master.handle(joined(name))
    await administration.configure("m1", SETTINGS)
    await administration.remove("m2")
    await administration.remove("m3")
    await administration.admit("m3")
    again, _ = started(file)
    for name in ("m1", "m3"):
        again.handle(joined(name))
    assert again.machines["m1"].settings == SETTINGS and again.machines["m3"].settings == MachineSettings()
    with pytest.raises(NotPermitted):
        again.handle(joined("m2"))


@pytest.mark.parametrize(
    "kept", [b"", b"[]", b"\xff", b'{"settings": {"m1": {"max_containers": -1}}, "removed": []}'], ids=str
)
def test_invalid_settings_file_is_refused_by_name(tmp_path: Path, kept: bytes) -> None:
    file = tmp_path / "settings.json"
    file.write_bytes(kept)
    with pytest.raises(InvalidInput, match=r"settings\.json is not a valid file"):
        started(file)


async def test_settings_that_cannot_be_saved_take_effect_with_an_error(tmp_path: Path) -> None:
    (tmp_path / "data").write_bytes(b"no folder")
    master, administration = started(tmp_path / "data" / "settings.json")
    master.handle(joined("m1"))
    with pytest.raises(Unavailable, match="in effect, but it was not saved"):
        await administration.configure("m1", SETTINGS)
    assert master.machines["m1"].settings == SETTINGS


def test_registry_has_the_last_noted_machines(tmp_path: Path) -> None:
    registry = MachineRegistry(tmp_path / "here.json")
    assert registry.left() == []
    registry.note(["m2", "local"])
    assert MachineRegistry(tmp_path / "here.json").left() == ["local", "m2"]
    registry.note([])
    assert registry.left() == [] and list(tmp_path.iterdir()) == []


def test_unreadable_registry_is_empty_and_unwritable_one_is_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "here.json").write_text('{"m1": 1}')
    assert MachineRegistry(tmp_path / "here.json").left() == []
    caplog.set_level(logging.WARNING)
    MachineRegistry(tmp_path / "here.json" / "below").note(["m1"])
    assert "could not store the names of machines" in caplog.text
