"""Containers of a cloud, as operators see and change them."""

from collections.abc import Callable, Iterator, Mapping

from engine.master.events import ResizeRequested
from engine.master.master import Master
from engine.master.orders import Order
from engine.master.places import Place
from engine.protocols.control_link import StopContainer
from engine.service.links.control_server import ControlServer
from engine.service.links.place_link import PlaceLink
from engine.service.start_times import StartTimes
from engine.service.view_building import container_view
from engine.service.views import ContainerView
from engine.specs.containers import ContainerSpec, RobotConfig


class Containers:
    """Shows containers, ends and resizes them; implements ``ContainerCalls``.

    Parameters
    ----------
    master : Master
        Master that has the places.
    links : mapping of str to PlaceLink
        Links of the open places, by their names.
    control : ControlServer
        Sends orders to machines.
    times : StartTimes
        Times at which containers were started.
    execute : callable
        Executes the master's orders.
    is_here : callable
        Returns whether the robot of a place is connected.
    """

    def __init__(
        self,
        master: Master,
        links: Mapping[str, PlaceLink],
        control: ControlServer,
        times: StartTimes,
        *,
        execute: Callable[[list[Order]], None],
        is_here: Callable[[str], bool],
    ) -> None:
        self._master = master
        self._links = links
        self._control = control
        self._times = times
        self._execute = execute
        self._is_here = is_here

    async def views(self, user: str | None) -> list[ContainerView]:
        """Return the containers of a user, or of all users if None."""
        places = (place for place in self._master.places.values() if user in (None, place.request.user))
        return [view for place in places if (view := self._view(place)) is not None]

    def _view(self, place: Place) -> ContainerView | None:
        container = place.spec.id if place.spec is not None else ""
        machine = self._master.machines.get(place.machine or "")
        link = self._links.get(place.request.key)
        return container_view(
            place, machine, link, self._times.age(container), self._times.took(container),
            connected=self._is_here(place.request.key),
        )  # fmt: skip

    def running_robots(self) -> Iterator[tuple[ContainerSpec, RobotConfig]]:
        """Yield the robots with a running container."""
        for key, link in self._links.items():
            place = self._master.places.get(key)
            if link.container is not None and place is not None and place.spec is not None and place.spec.robot:
                yield place.spec, place.spec.robot

    async def give_up(self, container: str) -> None:
        """End a container as if it had died: its place gets another, and clients notice only a pause."""
        self._control.order(self._master.machine_of(container), StopContainer(container, grace=0.0))

    async def resize(self, container: str, cores: float) -> None:
        """Change the size of a running container [cores]."""
        self._execute(self._master.handle(ResizeRequested(container, cores)))
