"""Administration: machines and containers of a running cloud, as operators see and change them.

Settings and names of machines are on disk, for a cloud process that starts after this one was killed.
"""

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import msgspec

from engine.control.start_times import StartTimes
from engine.control.views import ContainerView, MachineView
from engine.links.control_server import ControlServer
from engine.links.place_link import PlaceLink
from engine.master.events import MachineAdmitted, RemovalRequested, ResizeRequested, SettingsChanged, SettingsLoaded
from engine.master.machine import Machine
from engine.master.master import Master
from engine.master.orders import Order
from engine.master.places import PlaceAssignment
from engine.processes.disk_notes import write_note
from engine.protocols.control_link import StopContainer
from engine.specs.containers import ContainerSpec, RobotConfig
from engine.specs.cores import memory
from engine.specs.machine_settings import MachineSettings, check_settings
from engine.specs.start_state import KernelProgress, StartState
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, PPaaSError, Unavailable

logger = logging.getLogger(__name__)


# -- machines ----------------------------------------------------------------------------------------------------------


class _Kept(msgspec.Struct, frozen=True):
    settings: dict[str, MachineSettings]
    removed: list[str]


class Administration:
    """Applies and stores the decisions of administrators about machines; implements ``MachineCalls``.

    Parameters
    ----------
    master : Master
        Master that the decisions are applied to.
    execute : callable
        Executes the master's orders.
    cut_off : callable
        Removes a machine, as it is requested, and closes its link.
    check_started : callable
        Raises ``Starting`` for a machine that has not joined yet but is about to.
    start_of : callable
        Returns the kernels that machines compile.
    """

    def __init__(
        self,
        master: Master,
        execute: Callable[[list[Order]], None],
        cut_off: Callable[[RemovalRequested], None],
        check_started: Callable[[str], None],
        start_of: Callable[[], StartState],
    ) -> None:
        self._master = master
        self._check_started = check_started
        self._start_of = start_of
        self._execute = execute
        self._cut_off = cut_off
        self._file: Path | None = None

    def keep_in(self, file: Path) -> None:
        """Load settings and removals from a file, and store later changes there.

        Raises
        ------
        InvalidInput
            The file is not valid.
        """
        self._file = file
        if not file.exists():
            return
        try:
            kept = from_json(file.read_bytes(), _Kept)
            settings = {machine: check_settings(said) for machine, said in kept.settings.items()}
        except (OSError, msgspec.DecodeError, UnicodeDecodeError, PPaaSError) as error:
            raise InvalidInput(
                f"{file} is not a valid file of machine settings: correct or delete it: {error}"
            ) from error
        self._execute(self._master.handle(SettingsLoaded(settings, tuple(kept.removed))))

    def _keep(self) -> None:
        if self._file is None:
            return
        try:
            write_note(self._file, _Kept(dict(self._master.settings), sorted(self._master.removed)))
        except OSError as error:
            raise Unavailable(
                f"the change is in effect, but it was not saved and is lost when the cloud ends: {error}"
            ) from error

    async def views(self) -> list[MachineView]:
        """Return all machines, and those that are about to join."""
        joined, kernels = self._master.machines, self._start_of().machines
        views = [machine_view(machine, kernels.get(machine.id)) for machine in joined.values()]
        return [*views, *(starting_view(name, kernels[name]) for name in kernels if name not in joined)]

    async def settings(self, machine: str) -> MachineSettings:
        """Return the settings of a machine that has joined."""
        self._check_started(machine)
        return self._master.machine(machine).settings

    async def configure(self, machine: str, settings: MachineSettings) -> None:
        """Apply and store settings of a machine that has joined."""
        self._check_started(machine)
        self._execute(self._master.handle(SettingsChanged(machine, settings)))
        self._keep()

    async def remove(self, machine: str, force: bool = False) -> None:
        """Disconnect a machine and refuse it until it is admitted again."""
        self._check_started(machine)
        self._cut_off(RemovalRequested(machine, force))
        self._keep()

    def is_removed(self, machine: str) -> bool:
        """Return whether a machine was removed and not admitted since."""
        return machine in self._master.removed

    async def admit(self, machine: str) -> None:
        """Accept a removed machine again."""
        if machine in self._master.removed:
            self._execute(self._master.handle(MachineAdmitted(machine)))
            self._keep()


class MachineRegistry:
    """Names of the connected machines, on disk.

    Parameters
    ----------
    file : Path
        The file. It exists while machines are connected, and after a cloud process was killed.
    """

    def __init__(self, file: Path) -> None:
        self._file = file

    def left(self) -> list[str]:
        """Return the machines of a killed cloud process; empty if there are none, or the file is not readable."""
        try:
            return from_json(self._file.read_bytes(), list[str])
        except (OSError, msgspec.DecodeError):
            return []  # robots then do not wait for machines, and only get new containers

    def note(self, machines: Iterable[str]) -> None:
        """Store the names of the machines; without machines, delete the file."""
        names = sorted(machines)
        try:
            if names:
                write_note(self._file, names)
            else:
                self._file.unlink(missing_ok=True)
        except OSError as error:
            logger.warning(
                "could not store the names of machines; if this process is killed, robots do not wait for them: %s",
                error,
            )


# -- containers --------------------------------------------------------------------------------------------------------


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

    def of_robot(self, key: str) -> ContainerView | None:
        """Return the container of the robot of a place, or None."""
        place = self._master.places.get(key)
        return None if place is None else self._view(place)

    def _view(self, place: PlaceAssignment) -> ContainerView | None:
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


# -- views -------------------------------------------------------------------------------------------------------------


def starting_view(machine: str, kernels: KernelProgress | None) -> MachineView:
    """Return the view of a machine that has not joined yet, and how far its kernels are."""
    return MachineView(
        id=machine, cores=0, capacity=0.0, containers=0, memory=0, memory_used=0, load=0.0, state="starting",
        kernels=kernels,
    )  # fmt: skip


def machine_view(machine: Machine, kernels: KernelProgress | None = None) -> MachineView:
    """Return the view of a machine, and of the kernels that it compiles."""
    settings = machine.settings
    return MachineView(
        id=machine.id,
        cores=machine.cores,
        capacity=machine.capacity,
        containers=len(machine.containers),
        memory=machine.memory,
        memory_used=machine.memory_used,
        load=machine.cpu,
        given=machine.given,
        memory_given=memory(machine.given),
        state=("drained" if not machine.containers else "draining") if settings.draining else "ready",
        labels=machine.all_labels,
        max_containers=settings.max_containers,
        max_memory=settings.max_memory,
        oversubscription=settings.oversubscription,
        draining=settings.draining,
        network=machine.network or None,
        network_used=machine.network_used,
        round_trip=machine.round_trip,
        round_trips=machine.neighbours,
        kernels=kernels,
        release=machine.software.release,
        protocol=machine.software.protocol,
    )


def container_view(
    place: PlaceAssignment,
    machine: Machine | None,
    link: PlaceLink | None,
    age: float,
    ready_seconds: float | None,
    *,
    connected: bool,
) -> ContainerView | None:
    """Return the view of a place's container; None if it has none.

    Parameters
    ----------
    place : PlaceAssignment
    machine : Machine, optional
        Machine of the container.
    link : PlaceLink, optional
        Link of the place.
    age : float
        Time since the order to start it [s].
    ready_seconds : float, optional
        Time from the order to its machine until it answered [s].
    connected : bool
        Whether its robot is connected.
    """
    spec = place.spec
    if spec is None:
        return None
    load = machine.loads.get(spec.id) if machine is not None else None
    return ContainerView(
        id=spec.id,
        kind=spec.kind,
        user=spec.user,
        robot=spec.robot.id if spec.robot is not None else None,
        map=spec.map,
        machine=place.machine or "",
        cores=spec.cores,
        state="ready" if place.state == "ready" else "starting",
        pid=place.pid,
        pss=load.pss if load is not None else None,
        ready_seconds=ready_seconds,
        cpu=load.cpu if load is not None else None,
        age=age,
        clients=link.clients if link is not None else 0,
        connected=connected,
        round_trip=link.beat.round_trip if link is not None else None,
        masks=tuple(mask.id for mask in spec.robot.masks.values()) if spec.robot is not None else (),
    )
