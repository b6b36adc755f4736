"""Teleoperation: who drives a robot by hand, and which commands of the driver still count.

Commands in, velocity out. Only one client drives at a time. It becomes the driver by a request, and is it until it
leaves, another takes over, or nothing comes from it for some time.

A velocity counts while the driver holds the dead-man's control and commands keep coming. Clocks of browsers are not
compared with the clock here: each state that is published has a number, and a command echoes the number of the last one
that came, with the time since. So the age of a command is at most the round trip, and the age of what the driver sees
is known likewise. After a fault the driver has to let go of the control: the robot does not move by itself when a link
recovers.
"""

import math
from dataclasses import dataclass

from ppaas.bounded import BoundedDict
from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput
from ppaas.messages.operators.teleoperation import DriverRequest, TeleopCommand
from ppaas.parameters import Parameters, check_numbers

MOST_STATES = 1024
"""Number of published states whose times are known; an older one counts as too old."""

LONGEST_ID = 64
"""Longest id of a driver [characters]."""

STAND = Velocity()


class TeleopParameters(Parameters, frozen=True):
    """Parameters of teleoperation, named ``teleop`` in robot files.

    Parameters
    ----------
    max_vel_x, max_vel_theta : float
        Fastest speeds, forward and in reverse, and turning [m/s, rad/s]; those of the robot's model hold, too.
    command_timeout : float
        Age of a command, and time without one, above which the robot stops [s].
    view_timeout : float
        Age of the view above which the robot stops [s].
    lease_timeout : float
        Time without any command after which the driver is none any more [s].
    max_rate : float
        Largest rate at which commands are passed on to the base [1/s]; a stop is passed on at once.
    reaction_time : float
        Time until a driver and the base react to an obstacle; the robot stops farther before it [s].
    """

    max_vel_x: float = 0.5
    max_vel_theta: float = 1.0
    command_timeout: float = 0.3
    view_timeout: float = 1.0
    lease_timeout: float = 2.0
    max_rate: float = 50.0
    reaction_time: float = 0.3

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=self.__struct_fields__)


@dataclass(slots=True)
class HandDriver:
    """The client that drives.

    Parameters
    ----------
    id, name : str
        Id of the client, and its user.
    number : int
        Number of its last command.
    heard_at : float
        Time of its last command [s].
    lock : str
        Reason for which it has to let go of the control; empty for none.
    wanted : Velocity
        Velocity that it wants.
    wanted_at : float
        Time of the command that said so [s].
    """

    id: str
    name: str
    number: int
    heard_at: float
    lock: str = ""
    wanted: Velocity = STAND
    wanted_at: float = -math.inf


class Teleoperation:
    """HandDriver of one robot, and the velocity that counts.

    Parameters
    ----------
    parameters : TeleopParameters
    fastest : Velocity
        Fastest speeds.

    Attributes
    ----------
    driver : HandDriver or None
        None while nobody drives.
    gave_back : bool
        Whether the last driver ended the turn by giving the robot back.
    """

    def __init__(self, parameters: TeleopParameters, fastest: Velocity) -> None:
        self.driver: HandDriver | None = None
        self.gave_back = False
        self._parameters = parameters
        self._fastest = fastest
        self._number = 0
        self._published: BoundedDict[int, float] = BoundedDict(MOST_STATES)

    def next_state(self, now: float) -> int:
        """Return the number of a state that is published now."""
        self._number += 1
        self._published[self._number] = now
        return self._number

    # -- commands ------------------------------------------------------------------------------------------------------

    def take(self, command: TeleopCommand, now: float) -> None:
        """Take a command; one of a client that does not drive counts only if it requests to.

        Raises
        ------
        InvalidInput
            A number is not finite, the id is empty or too long, or the request is unknown.
        """
        request = _checked(command)
        if request in (DriverRequest.DRIVE, DriverRequest.TAKE_OVER):
            self._request(command, now, take_over=request is DriverRequest.TAKE_OVER)
        driver = self.driver
        if driver is None or command.id != driver.id or command.number <= driver.number:
            return
        driver.number, driver.heard_at = command.number, now
        if request in (DriverRequest.LEAVE, DriverRequest.GIVE_BACK):
            self.driver, self.gave_back = None, request is DriverRequest.GIVE_BACK
        else:
            self._obey(driver, command, now)

    def _request(self, command: TeleopCommand, now: float, *, take_over: bool) -> None:
        if self.driver is None or (take_over and self.driver.id != command.id):
            self.driver, self.gave_back = HandDriver(command.id, command.driver, command.number - 1, now), False
            if command.enable:
                self.stop("the control was held before the robot was taken")

    def _obey(self, driver: HandDriver, command: TeleopCommand, now: float) -> None:
        if not command.enable:
            driver.wanted, driver.lock = STAND, ""
        elif not driver.lock:
            if reason := self._lateness(command, now):
                self.stop(reason)
            else:
                driver.wanted = self._slowed(Velocity(command.linear, command.angular))
                driver.wanted_at = now

    def _lateness(self, command: TeleopCommand, now: float) -> str:
        """Return why a command does not count; empty if it does."""
        limits = self._parameters
        late = self._age(command.echo, now) - command.held
        if late > limits.command_timeout:
            return f"commands came {_seconds(late)} late"
        old = self._age(command.view, now)
        return f"the view is {_seconds(old)} old" if old > limits.view_timeout else ""

    def _age(self, number: int, now: float) -> float:
        return now - self._published.get(number, -math.inf)

    def _slowed(self, wanted: Velocity) -> Velocity:
        """Return a velocity on the same arc that is not faster than the limits."""
        fastest = self._fastest
        excess = max(abs(wanted.linear) / fastest.linear, abs(wanted.angular) / fastest.angular, 1.0)
        return Velocity(wanted.linear / excess, wanted.angular / excess)

    # -- time passes ---------------------------------------------------------------------------------------------------

    def velocity(self, now: float) -> Velocity:
        """Return the velocity that the driver wants; none if its last command is too old."""
        driver, limit = self.driver, self._parameters.command_timeout
        if driver is None or driver.wanted == STAND:
            return STAND
        if now - driver.wanted_at > limit:
            self.stop(f"no command came for {limit:g} s")
        return driver.wanted

    def stop(self, reason: str) -> None:
        """Want no motion until the driver has let go of the control."""
        if self.driver is not None:
            self.driver.wanted, self.driver.lock = STAND, reason

    def expire(self, now: float) -> None:
        """End the driver's turn if nothing came from it for too long."""
        if self.driver is not None and now - self.driver.heard_at > self._parameters.lease_timeout:
            self.driver = None


def _checked(command: TeleopCommand) -> DriverRequest:
    numbers = command.linear, command.angular, command.held
    if not all(map(math.isfinite, numbers)) or command.held < 0.0:
        raise InvalidInput(f"linear, angular and held of a command must be finite, and held at least 0, not {numbers}")
    if not 0 < len(command.id) <= LONGEST_ID:
        raise InvalidInput(f"the id of a driver has from 1 to {LONGEST_ID} characters, not {len(command.id)}")
    try:
        return DriverRequest(command.request)
    except ValueError:
        known = ", ".join(repr(str(each)) for each in DriverRequest)
        raise InvalidInput(f"request must be one of {known}, not {command.request[:32]!r}") from None


def _seconds(age: float) -> str:
    return f"{age:.1f} s" if math.isfinite(age) else "too many seconds"
