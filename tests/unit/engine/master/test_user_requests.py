"""Requests of users: sizes of running containers, as the master counts them."""

import pytest

from engine.master.balancers.ppaas import SameMap
from engine.master.events import ContainerLost, ContainerReady, PlaceReleased, PlaceRequested, ResizeRequested
from engine.master.master import Master
from engine.master.orders import Resize, Start
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas, Used
from ppaas.errors import InvalidParameter, NotFound, QuotaExceeded, Unavailable
from tests.support.engine.placing import joined
from tests.support.engine.specs import HOUSE, robot_config


def request(name: str = "tb1", cores: float = 1.0) -> PlaceRequest:
    return PlaceRequest("ann", HOUSE, cores, robot_config(name))


@pytest.fixture
def quotas() -> Quotas:
    return Quotas(Quota(cores=4.0))


@pytest.fixture
def master(quotas: Quotas) -> Master:
    made = Master(SameMap(), quotas)
    made.handle(joined("m1", 2, memory=8 << 30))
    return made


def ready(master: Master, name: str = "tb1", cores: float = 1.0) -> str:
    """Open a place; return its container, which is ready."""
    [start] = master.handle(PlaceRequested(request(name, cores)))
    assert isinstance(start, Start)
    master.handle(ContainerReady(start.spec.id, 77))
    return start.spec.id


@pytest.mark.parametrize("cores", [2.0, 0.25])
def test_resized_container_counts_with_its_new_size(master: Master, quotas: Quotas, cores: float) -> None:
    container = ready(master)
    assert master.handle(ResizeRequested(container, cores)) == [Resize("m1", container, cores)]
    assert (master.machines["m1"].given, quotas.used("ann")) == (cores, Used(1, cores))
    master.handle(PlaceReleased("robot:ann/tb1"))
    assert (master.machines["m1"].given, quotas.used("ann")) == (0.0, Used())


def test_replacement_has_the_new_size(master: Master) -> None:
    container = ready(master)
    master.handle(ResizeRequested(container, 1.5))
    [start] = master.handle(ContainerLost(container, Unavailable("boom"), 100.0))
    assert isinstance(start, Start) and start.spec.cores == 1.5


def test_reopened_place_has_the_requested_size(master: Master) -> None:
    master.handle(ResizeRequested(ready(master), 1.5))
    master.handle(PlaceReleased("robot:ann/tb1"))
    [start] = master.handle(PlaceRequested(request()))
    assert isinstance(start, Start) and start.spec.cores == 1.0


def test_resize_above_the_quota_is_refused(master: Master) -> None:
    first, second, _ = ready(master, "tb1", 2.0), ready(master, "tb2", 1.5), ready(master, "tb3", 0.25)
    with pytest.raises(QuotaExceeded, match=r"4 cores and has 3\.75; 0\.5 more"):
        master.handle(ResizeRequested(second, 2.0))
    master.handle(ResizeRequested(second, 1.75))
    master.handle(ResizeRequested(first, 0.5))


@pytest.mark.parametrize(
    ("cores", "error"), [(0.0, InvalidParameter), (float("nan"), InvalidParameter), (3.0, QuotaExceeded)]
)
def test_invalid_size_is_refused_and_changes_nothing(
    master: Master, quotas: Quotas, cores: float, error: type[Exception]
) -> None:
    container = ready(master)
    with pytest.raises(error):
        master.handle(ResizeRequested(container, cores))
    assert (master.machines["m1"].given, quotas.used("ann").cores) == (1.0, 1.0)


def test_resize_above_the_free_cores_is_refused_with_their_number() -> None:
    master = Master(SameMap(), Quotas())
    master.handle(joined("m1", 2, memory=8 << 30))
    first, *_ = [ready(master, f"tb{number}", cores) for number, cores in enumerate([1.0, 2.0, 2.0, 2.0, 0.5])]
    with pytest.raises(Unavailable, match=r"'m1' has 0\.5 free cores, but 0\.75 more are needed"):
        master.handle(ResizeRequested(first, 1.75))
    assert master.handle(ResizeRequested(first, 1.5))


def test_unready_or_unknown_container_cannot_be_resized(master: Master) -> None:
    [start] = master.handle(PlaceRequested(request()))
    assert isinstance(start, Start)
    with pytest.raises(Unavailable, match="when it is ready"):
        master.handle(ResizeRequested(start.spec.id, 0.5))
    with pytest.raises(NotFound):
        master.handle(ResizeRequested("c99", 0.5))
