"""Clone service: checkpoints and logs of the container's own clone only."""

import pytest

from engine.agent import store_requests
from engine.agent.store_requests import LOG_PAGE, CloneService
from engine.protocols import machine_link
from ppaas.errors import NotPermitted
from storage.memory.store import MemoryStore
from storage.records import CloneLogChange
from tests.support.engine.specs import planning_spec, robot_spec


def test_checkpoint_and_changes_of_logs_are_stored_together() -> None:
    store = MemoryStore()
    service, spec = CloneService(store), robot_spec("c1", "ann", "tb1")
    service.save(spec, machine_link.SaveClone(1, {"amcl": b"{}"}, [CloneLogChange("slam", {1: b"x"})]), "cloud-1")
    assert store.clone("ann", "tb1").nodes["amcl"] == b"{}"
    assert service.log(spec, machine_link.ReadLog(2, "slam", -1)) == machine_link.LogRead(2, [(1, b"x")])
    assert service.log(spec, machine_link.ReadLog(3, "slam", 1)) == machine_link.LogRead(3, [])


def test_a_long_log_is_answered_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_requests, "LOG_BYTES", 1)
    service, spec = CloneService(MemoryStore()), robot_spec("c1", "ann", "tb1")
    entries = {number: bytes(10) for number in range(LOG_PAGE + 1)}
    service.save(spec, machine_link.SaveClone(1, {}, [CloneLogChange("slam", entries)]), "cloud-1")
    first = service.log(spec, machine_link.ReadLog(2, "slam", -1)).entries
    rest = service.log(spec, machine_link.ReadLog(3, "slam", first[-1][0])).entries
    assert (len(first), dict([*first, *rest])) == (LOG_PAGE, entries)


def test_a_container_without_a_clone_is_refused() -> None:
    service, spec = CloneService(MemoryStore()), planning_spec()
    with pytest.raises(NotPermitted, match="has no clone"):
        service.save(spec, machine_link.SaveClone(1, {}), "cloud-1")
    with pytest.raises(NotPermitted, match="has no clone"):
        service.log(spec, machine_link.ReadLog(2, "slam", -1))
