"""The master, as a pure state machine: events in, orders out.

It places containers, counts quotas, and replaces lost containers. It starts nothing itself, and no message of a robot
passes through it. ``engine.service.master_driver`` executes its orders.

A *place* is what a user holds: the clone of a robot, or planning on a map version. The containers that fill it are
replaced over time. Each has its own id, so that a late report about a dead container is never applied to its successor.
"""

from collections.abc import Callable, Iterable

from engine.master.balancer import Balancer
from engine.master.crashes import CRASH_WINDOW, note_crash
from engine.master.draining import move_on
from engine.master.machine import Machine
from engine.master.orders import Close, Order
from engine.master.placement_diagnostics import check_fits, explain_no_machine
from engine.master.places import PlaceRequest
from engine.master.quotas import Quotas
from engine.master.resizing import resize
from engine.master.state import MasterState
from engine.protocols.control_link import RunningContainer
from engine.specs.machine_settings import MachineSettings, check_settings
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, InvalidInput, NotFound, NotPermitted, PPaaSError, Unavailable


class Master:
    """Decides where containers run; turns events into orders.

    Parameters
    ----------
    balancer : Balancer
        Balancer that chooses machines.
    quotas : Quotas
        Quotas of the users, where their usage is counted.
    clock : callable
        Returns monotonic seconds.
    new_id : callable
        Returns the next container id.
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

    # -- requests of users ---------------------------------------------------------------------------------------------

    def open(self, request: PlaceRequest) -> list[Order]:
        """Open a place and fill it; a place that is open already is left unchanged.

        Raises
        ------
        InvalidParameter
            The size is not positive.
        QuotaExceeded
            The size exceeds the CPUs of every machine, or the user's quota of containers or cores.
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
            raise Unavailable(explain_no_machine(request, self.machines))
        return orders

    def close(self, key: str) -> list[Order]:
        """Close a place, if it is open; waiting places get its room."""
        place = self.state.drop(key)
        return [*self.state.empty(place), *self._use_room()] if place is not None else []

    def resize(self, container: str, cores: float) -> list[Order]:
        """Change the size of a container; its place keeps the new size while it is open.

        Raises
        ------
        NotFound
            There is no such container.
        InvalidParameter, QuotaExceeded, Unavailable
            As ``engine.master.resizing.resize`` raises them.
        """
        machine = self.machine(self.carrier(container))
        place = self.places[self.state.place_of[container]]
        return [resize(place, machine, cores, self._balancer, self.quotas), *self._use_room()]

    # -- requests of administrators ------------------------------------------------------------------------------------

    def configure(self, machine_id: str, settings: MachineSettings) -> list[Order]:
        """Apply the settings of a machine, now and whenever it reconnects; start to drain it if they say so.

        Containers that it already runs stay, even if they exceed the new limits.

        Raises
        ------
        InvalidParameter
            A setting is not valid.
        NotFound
            There is no such machine.
        """
        machine = self.machine(machine_id)
        self.settings[machine_id] = check_settings(settings)
        self._apply(settings, machine)
        self._balancer.measured(machine)
        return self._use_room()

    def remove(self, machine_id: str, *, force: bool = False) -> list[Order]:
        """Remove a machine and refuse it from now on.

        With ``force``, also a machine that runs containers; these are replaced as if the machine had failed.

        Raises
        ------
        Conflict
            It runs containers.
        NotFound
            There is no such machine.
        """
        carries = len(self.machine(machine_id).containers)
        if carries and not force:
            raise Conflict(f"machine {machine_id!r} runs {carries} containers: drain it first, or force its removal")
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
        """Accept a removed machine again."""
        self.removed.discard(machine_id)

    def machine(self, machine_id: str) -> Machine:
        """Return a machine; raises ``NotFound`` if there is no such machine."""
        if machine_id not in self.machines:
            raise NotFound("machine", machine_id, list(self.machines))
        return self.machines[machine_id]

    # -- events of machines --------------------------------------------------------------------------------------------

    def machine_joined(self, machine: Machine, carries: Iterable[RunningContainer] = ()) -> list[Order]:
        """Add a machine with its settings, adopt its containers, and fill waiting places.

        Raises
        ------
        NotPermitted
            An administrator removed it.
        """
        if machine.id in self.removed:
            raise NotPermitted(f"machine {machine.id!r} was removed: an administrator must admit it first")
        orders = self.machine_left(machine.id)
        self._apply(self.settings.get(machine.id, machine.settings), machine)
        self.machines[machine.id] = machine
        self._balancer.joined(machine)
        self.returning.discard(machine.id)
        orders += [order for carried in carries for order in self.state.adopt(machine, carried)]
        return orders + self._use_room()

    def move_on(self) -> list[Order]:
        """Continue draining: return orders that make containers leave, a few at once."""
        return move_on(self.state)

    def wait_no_more(self) -> list[Order]:
        """Stop waiting for the machines in ``returning``; fill the places of robots whose clones might run there."""
        self.returning.clear()
        return self._use_room()

    def machine_left(self, machine_id: str) -> list[Order]:
        """Remove a machine and place its containers on others; places without room wait for the next machine."""
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
        """Notify the balancer of a new load of a machine."""
        if machine_id in self.machines:
            self._balancer.measured(self.machines[machine_id])

    def robot_timed(self, key: str, round_trip: float) -> None:
        """Record the round trip between a robot and the machine that serves it [s]."""
        place = self.places.get(key)
        machine = self.machines.get(place.machine or "") if place is not None else None
        if place is not None and place.spec is not None and machine is not None:
            machine.served[place.spec.id] = round_trip
            self._balancer.timed(place.spec.serves, machine.id, round_trip)

    # -- events of containers ------------------------------------------------------------------------------------------

    def container_launched(self, container: str, pid: int) -> None:
        """Record the process id of a container."""
        place = self.state.filled_by(container)
        if place is not None:
            place.pid = pid

    def container_ready(self, container: str, pid: int) -> str | None:
        """Mark a container as ready; return the name of the place it fills, or None if it fills none."""
        place = self.state.filled_by(container)
        if place is None:
            return None
        place.state = "ready"
        place.pid = place.pid or pid  # the pid on the machine counts: inside a Docker container it may differ
        self.state.moving.discard(place.request.key)
        return place.request.key

    def container_lost(self, container: str, reason: PPaaSError) -> list[Order]:
        """Replace a container that exited or could not be started.

        The delay grows with each crash. The place is closed after too many crashes, or if the reason is the request
        itself, so that another attempt would fail the same way.
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
        """Return the name of the machine of a container; raises ``NotFound`` if there is no such container."""
        place = self.state.filled_by(container)
        if place is None or place.machine is None:
            raise NotFound("container", container)
        return place.machine

    def check_carries(self, machine_id: str, container: str) -> None:
        """Check that a machine reports on its own containers only, present or former.

        Raises
        ------
        NotPermitted
            The container runs on another machine.
        """
        place = self.state.filled_by(container)
        if place is not None and place.machine != machine_id:
            raise NotPermitted(f"machine {machine_id!r} reported on container {container!r} of another machine")

    def is_leaving(self, container: str) -> bool:
        """Return whether a container was ordered to leave its machine."""
        place = self.state.filled_by(container)
        return place is not None and place.leaving

    # -- private -------------------------------------------------------------------------------------------------------

    def _give_up(self, key: str, reason: PPaaSError) -> list[Order]:
        self.state.drop(key)
        return [Close(key, reason), *self._use_room()]

    def _use_room(self) -> list[Order]:
        filled = [order for key in tuple(self.state.waiting) for order in self.state.fill(key, self.places[key])]
        return [*filled, *move_on(self.state)]
