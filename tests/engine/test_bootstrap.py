import logging

import pytest

from engine import bootstrap
from engine.bootstrap import Cloud, CloudConfig


@pytest.mark.parametrize(("usual", "told"), [(0.0, True), (600.0, False)])
async def test_a_start_that_takes_longer_than_usual_says_why(tmp_path, short_path, monkeypatch, caplog, usual, told):
    monkeypatch.setattr(bootstrap, "USUAL_START", usual)
    caplog.set_level(logging.INFO)
    cloud = Cloud(CloudConfig(f"sqlite:///{tmp_path / 'store.sqlite'}", f"file:///{tmp_path / 'maps'}"))
    try:
        await cloud.start()
        assert [machine.id for machine in cloud.machines()] == ["local"]
    finally:
        await cloud.close()
    assert (bootstrap.STILL_STARTING in caplog.text) is told
    assert list(short_path.iterdir()) == []
