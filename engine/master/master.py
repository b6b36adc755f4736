"""The master, as a pure state machine: events in, orders out.

It places, counts and decides what happens to what is lost. It starts nothing itself, and no message of a robot passes
through it. ``engine.service.master_driver`` carries its orders out.

A *place* is what a user has, for as long as the user wants it: the clone of a robot, or planning on a map. The
containers that fill it come and go; each has an id of its own, so that news of a dead one is never taken for news of
the one that replaced it.
"""

from collections.abc import Callable, Iterable

from engine.master.balancer import Balancer
from engine.master.crashes import CRASH_WINDOW, note_crash
from engine.master.draining import move_on
from engine.master.machine import Machine
from engine.master.orders import Close, Order
from engine.master.placement_diagnostics import check_fits, why_none
from engine.master.places import PlaceRequest
from engine.master.quotas import Quotas
from engine.master.resizing import resize
from engine.master.state import MasterState
from engine.protocols.control_link import RunningContainer
from engine.specs.machine_settings import MachineSettings, check_settings
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, InvalidInput, NotFound, NotPermitted, PPaaSError, Unavailable


class Master:
    """Machines, places and containers.

    Parameters
    ----------
    balancer : Balancer
        Chooses machines.
    quotas : Quotas
        Of the users; what they have is counted there.
    clock : callable
        Monotonic seconds.
    new_id : callable
        Gives the next container id.
    """

    def __init__(
        self,
        balancer: Balancer,
        quotas: Quotas | None = None,
        clock: Clock = monotonic,
        new_id: Callable[[], str] | None = None,
    ) -> None:
        self._balancer = balancer
        self.quotas = quotas or Quotas()
        self._clock = clock
        self.state = MasterState(balancer, self.quotas, new_id)
        self.machines = self.state.machines
        self.places = self.state.places
        self.returning = self.state.returning
        self.settings: dict[str, MachineSettings] = {}
        self.removed: set[str] = set()

    # -- what users want -----------------------------------------------------------------------------------------------

    def open(self, request: PlaceRequest) -> list[Order]:
        """Make a place and fill it; a place that is there already is left as it is.

        Raises
        ------
        InvalidParameter
            A size that is not positive.
        QuotaExceeded
            The user has too many containers or cores.
        Unavailable
            No machine has room.
        """
        if request.key in self.places:
            return []
        check_fits(request, self.machines.values(), self.quotas)
        place = self.state.add(request)
        orders = self.state.fill(request.key, place)
        if not orders and self.machines and not self.state.may_run(place):
            self.state.drop(request.key)
            raise Unavailable(why_none(request, self.machines))
        return orders

    def close(self, key: str) -> list[Order]:
        """Give a place up, if it is there; what it had is room for places that wait."""
        place = self.state.drop(key)
        return [*self.state.empty(place), *self._use_room()] if place is not None else []

    def resize(self, container: str, cores: float) -> list[Order]:
        """Give a container another size, which its place keeps while it is open.

        Raises
        ------
        NotFound
            There is no such container, or no longer.
        InvalidParameter, QuotaExceeded, Unavailable
            As ``engine.master.resizing.resize`` says.
        """
        machine = self.machine(self.carrier(container))
        place = self.places[self.state.place_of[container]]
        return [resize(place, machine, cores, self._balancer, self.quotas), *self._use_room()]

    # -- what administrators want --------------------------------------------------------------------------------------

    def configure(self, machine_id: str, settings: MachineSettings) -> list[Order]:
        """Take over what is said of a machine, also for when it comes again; from one that is drained all moves away.

        What it carries already stays, whatever its limits are now.

        Raises
        ------
        InvalidParameter
            What is said cannot be meant.
        NotFound
            There is no such machine.
        """
        machine = self.machine(machine_id)
        self.settings[machine_id] = check_settings(settings)
        self._apply(settings, machine)
        self._balancer.measured(machine)
        return self._use_room()

    def remove(self, machine_id: str, *, force: bool = False) -> list[Order]:
        """Forget a machine and let it in no more.

        With ``force`` also one that carries something, which is lost then as with a machine that vanishes.

        Raises
        ------
        Conflict
            It carries something.
        NotFound
            There is no such machine.
        """
        carries = len(self.machine(machine_id).containers)
        if carries and not force:
            raise Conflict(f"machine {machine_id!r} carries {carries} containers: drain it first, or force it")
        self.settings.pop(machine_id, None)
        self.removed.add(machine_id)
        return self.machine_left(machine_id)

    def _apply(self, settings: MachineSettings, machine: Machine) -> None:
        machine.settings = settings
        if settings.draining:
            self.state.draining.add(machine.id)
        else:
            self.state.draining.discard(machine.id)

    def admit(self, machine_id: str) -> None:
        """Let a machine in again that was removed."""
        self.removed.discard(machine_id)

    def machine(self, machine_id: str) -> Machine:
        """Return a machine; ``NotFound`` if there is none."""
        if machine_id not in self.machines:
            raise NotFound("machine", machine_id, list(self.machines))
        return self.machines[machine_id]

    # -- what happens to machines --------------------------------------------------------------------------------------

    def machine_joined(self, machine: Machine, carries: Iterable[RunningContainer] = ()) -> list[Order]:
        """Take a machine in with its settings, adopt what it carries, and fill the places that wait for one.

        Raises
        ------
        NotPermitted
            An administrator removed it.
        """
        if machine.id in self.removed:
            raise NotPermitted(f"machine {machine.id!r} was removed: an administrator can admit it again")
        orders = self.machine_left(machine.id)
        self._apply(self.settings.get(machine.id, machine.settings), machine)
        self.machines[machine.id] = machine
        self._balancer.joined(machine)
        self.returning.discard(machine.id)
        orders += [order for carried in carries for order in self.state.adopt(machine, carried)]
        return orders + self._use_room()

    def move_on(self) -> list[Order]:
        """Let containers leave machines that are drained, some at a time, those that are ready and fit elsewhere."""
        return move_on(self.state)

    def wait_no_more(self) -> list[Order]:
        """Fill the places of robots that wait for the ``returning``, where their clones may run."""
        self.returning.clear()
        return self._use_room()

    def machine_left(self, machine_id: str) -> list[Order]:
        """Place what a vanished machine carried anew; what finds no room waits for the next machine."""
        machine = self.machines.pop(machine_id, None)
        if machine is None:
            return []
        self._balancer.left(machine)
        self.state.draining.discard(machine_id)
        orders: list[Order] = []
        for container in tuple(machine.containers):
            place = self.state.filled_by(container)
            if place is not None:
                self.state.empty(place)
                orders += self.state.fill(place.request.key, place)
            else:
                self.places[self.state.place_of.pop(container)].successor = None
        return orders

    def machine_measured(self, machine_id: str) -> None:
        """Note that what is known of the load of a machine is new."""
        if machine_id in self.machines:
            self._balancer.measured(self.machines[machine_id])

    def robot_timed(self, key: str, round_trip: float) -> None:
        """Note the round trip between a robot and the machine that serves it [s]."""
        place = self.places.get(key)
        machine = self.machines.get(place.machine or "") if place is not None else None
        if place is not None and place.spec is not None and machine is not None:
            machine.served[place.spec.id] = round_trip
            self._balancer.timed(place.spec.serves, machine.id, round_trip)

    # -- what happens to containers ------------------------------------------------------------------------------------

    def container_launched(self, container: str, pid: int) -> None:
        """Note the process of a container."""
        place = self.state.filled_by(container)
        if place is not None:
            place.pid = pid

    def container_ready(self, container: str, pid: int) -> str | None:
        """Note that a container answers; return the place it fills, or None if it is not awaited."""
        place = self.state.filled_by(container)
        if place is None:
            return None
        place.state = "ready"
        place.pid = place.pid or pid  # its machine knows better: in a container of Docker it may have another
        self.state.moving.discard(place.request.key)
        return place.request.key

    def container_lost(self, container: str, reason: PPaaSError) -> list[Order]:
        """Replace a container that exited or could not be started.

        Later each time it crashes again, and not where it does so too often, nor where the reason is what it was
        asked for: another try would end the same way.
        """
        place = self.state.filled_by(container)
        if place is None:
            return []
        key, left = place.request.key, place.leaving
        self.state.empty(place)
        if left:
            return self.state.fill(key, place)
        if isinstance(reason, InvalidInput | NotFound | Conflict):
            return self._give_up(key, reason)
        delay = note_crash(place, self._clock())
        if delay is None:
            text = f"the container failed {len(place.crashes)} times in {CRASH_WINDOW:.0f} s; the last time: {reason}"
            return self._give_up(key, Unavailable(text))
        return self.state.fill(key, place, delay)

    def carrier(self, container: str) -> str:
        """Return the machine of a container; ``NotFound`` if there is no such container, or no longer."""
        place = self.state.filled_by(container)
        if place is None or place.machine is None:
            raise NotFound("container", container)
        return place.machine

    def check_carries(self, machine_id: str, container: str) -> None:
        """Make sure that a machine speaks of what is its own, or was.

        Raises
        ------
        NotPermitted
            Another machine carries this container.
        """
        place = self.state.filled_by(container)
        if place is not None and place.machine != machine_id:
            raise NotPermitted(f"machine {machine_id!r} speaks of container {container!r}, which is on another")

    def is_leaving(self, container: str) -> bool:
        """Tell whether a container was ordered to leave its machine."""
        place = self.state.filled_by(container)
        return place is not None and place.leaving

    # -- inside --------------------------------------------------------------------------------------------------------

    def _give_up(self, key: str, reason: PPaaSError) -> list[Order]:
        self.state.drop(key)
        return [Close(key, reason), *self._use_room()]

    def _use_room(self) -> list[Order]:
        filled = [order for key in tuple(self.state.waiting) for order in self.state.fill(key, self.places[key])]
        return [*filled, *move_on(self.state)]
