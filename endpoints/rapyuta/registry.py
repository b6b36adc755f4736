"""Registry of robots of 2013: their login, connected ones, and those that may come back."""

import asyncio
import contextlib

from starlette.websockets import WebSocket

from endpoints.accounts.authentication import address_of, authenticate_socket, note_caller
from endpoints.audit.requests import note_details, note_object
from endpoints.rapyuta.executor import Executor
from endpoints.rapyuta.interfaces import EndpointTable
from endpoints.rapyuta.robot import Identity, RapyutaRobot, RobotConnection
from endpoints.resources.services import Services
from endpoints.rest.dependencies import check_unscoped
from endpoints.rosbridge import SessionRegistry
from engine.processes.background import Background, repeat
from ppaas.errors import Conflict, NotAuthenticated, NotFound, NotPermitted, PPaaSError, TooManyAttempts, Unavailable
from ppaas.wire.rapyuta.handshake import RobotLogin, is_digest
from storage.records import User

# Login by the SHA-256 hash of a separate password, where an administrator allows it, or by a token.

UNKNOWN = "(unknown)"
"""Name of all users who do not exist, in the audit log."""


async def log_in(socket: WebSocket, login: RobotLogin, services: Services) -> tuple[User, Identity]:
    """Return the user of a robot, and its login; note both for the audit log.

    A robot whose secret is a hash is logged in by the password that an administrator has set for this protocol, any
    other by a token, which is in the header ``Authorization`` or ``token`` of the query.

    Raises
    ------
    NotAuthenticated
        The user does not exist, may not log in so, or the password or the token is wrong.
    TooManyAttempts
        Too many logins of this user or from this address failed.
    """
    note_object(socket.scope, f"robots/{login.robot}")
    note_details(socket.scope, protocol="rapyuta")
    if is_digest(login.password) and not _has_token(socket):
        return await _by_digest(socket, login, services)
    user, token = await authenticate_socket(socket, services.accounts)
    if user.id != login.user:
        raise NotAuthenticated("the token is not one of the user in userID")
    check_unscoped(user)
    return user, Identity(user.id, token)


async def _by_digest(socket: WebSocket, login: RobotLogin, services: Services) -> tuple[User, Identity]:
    try:
        user, token = await services.accounts.rapyuta.sign_in(login.user, login.password, address_of(socket))
    except (NotAuthenticated, TooManyAttempts):
        known = await services.accounts.is_known(login.user)
        note_details(socket.scope, login=login.user if known else UNKNOWN)
        raise
    note_caller(socket.scope, user.id, token)
    return user, Identity(user.id, token, user.rapyuta_hash)


async def check_verifier(identity: Identity, services: Services) -> None:
    """Raise unless the password by which a robot logged in is still the one for this protocol.

    Raises
    ------
    NotPermitted
        An administrator has changed or removed it.
    """
    if not identity.verifier:
        return
    user = await services.accounts.user_of(identity.token)
    if user.rapyuta_hash != identity.verifier:
        raise NotPermitted("the password of this user for robots of Rapyuta was changed or removed")


def _has_token(socket: WebSocket) -> bool:
    return bool(socket.headers.get("authorization") or socket.query_params.get("token"))


RECONNECT_TIMEOUT = 10.0
"""Time for which a robot may be away before its containers and interfaces are removed [s], as in rce."""

PROBE_TIMEOUT = 2.0
"""Time limit of the probe of a robot's connection when another one comes for the same robot [s]."""

CHECK_PERIOD = 0.5
"""Interval of checks whether robots may still be logged in [s]."""


class RobotRegistry:
    """Robots by user and robot ID.

    Parameters
    ----------
    services : Services
        Services with the accounts and the store.
    sessions : SessionRegistry
        Attaches to places.
    reconnect : float
        Time for which a robot may be away [s].
    """

    def __init__(self, services: Services, sessions: SessionRegistry, reconnect: float = RECONNECT_TIMEOUT) -> None:
        self._services = services
        self._sessions = sessions
        self._reconnect = reconnect
        self._tables: dict[str, EndpointTable] = {}
        self._robots: dict[tuple[str, str], tuple[RapyutaRobot, Executor]] = {}
        self._background = Background()

    def __len__(self) -> int:
        """Return the number of robots, connected or away."""
        return len(self._robots)

    # -- connections ---------------------------------------------------------------------------------------------------

    async def attach(
        self, robot_id: str, identity: Identity, carrier: RobotConnection
    ) -> tuple[RapyutaRobot, Executor]:
        """Return a robot for a connection: a new one, or one that was away; `detach` must follow.

        Raises
        ------
        Conflict
            The robot is connected already and answers, or the user has a container of this name.
        """
        try:
            return await self._attach(robot_id, identity, carrier)
        except BaseException:
            self._revoke(identity)
            raise

    async def _attach(
        self, robot_id: str, identity: Identity, carrier: RobotConnection
    ) -> tuple[RapyutaRobot, Executor]:
        key = identity.user, robot_id
        while (known := self._robots.get(key)) is not None and known[0].carrier is not None:
            await self._displace(known[0].carrier)
        if known is None:
            known = self._begin(robot_id, identity)
        robot, executor = known
        if robot.identity != identity:
            self._revoke(robot.identity)
            robot.renew(identity)
        if robot.expiry is not None:
            robot.expiry.cancel()
            robot.expiry = None
        robot.carrier = carrier
        return robot, executor

    async def _displace(self, carrier: RobotConnection) -> None:
        if await carrier.answers(PROBE_TIMEOUT):
            raise Conflict("ID is already used for a container or robot: the robot is connected")
        await carrier.displace(Conflict("it did not answer, and another connection of this robot replaced it"))

    def _begin(self, robot_id: str, identity: Identity) -> tuple[RapyutaRobot, Executor]:
        table = self._tables.setdefault(identity.user, EndpointTable())
        robot = RapyutaRobot(robot_id, identity)
        table.add(robot)
        executor = Executor(robot, table, self._services, self._sessions)
        self._robots[identity.user, robot_id] = robot, executor
        return robot, executor

    def detach(self, robot: RapyutaRobot, carrier: RobotConnection) -> None:
        """Disconnect a robot; it may come back for a while, unless it must not."""
        if robot.carrier is carrier:
            robot.disconnect()
            if robot.over.done():
                self._end(robot)
            else:
                robot.expiry = asyncio.get_running_loop().call_later(self._reconnect, self._end, robot)
        carrier.left.set()

    def _end(self, robot: RapyutaRobot) -> None:
        key = robot.identity.user, robot.tag
        known = self._robots.get(key)
        if known is None or known[0] is not robot:
            return
        del self._robots[key]
        if robot.expiry is not None:
            robot.expiry.cancel()
        robot.end(Unavailable("the robot was away for too long"))
        known[1].destroy_all()
        table = self._tables[robot.identity.user]
        table.remove(robot)
        if not len(table):
            del self._tables[robot.identity.user]
        self._revoke(robot.identity)

    def _revoke(self, identity: Identity) -> None:
        """Revoke the token of a login by password, which nobody else knows."""
        if identity.verifier:
            self._background.run(self._revoked(identity))

    async def _revoked(self, identity: Identity) -> None:
        with contextlib.suppress(NotFound, Unavailable):  # revoked already, or it expires some day
            await self._services.accounts.revoke(identity.user, identity.token)

    async def close(self) -> None:
        """End all robots."""
        for robot, _ in tuple(self._robots.values()):
            self._end(robot)
        await self._background.join()

    # -- rights --------------------------------------------------------------------------------------------------------

    async def watch(self) -> None:
        """Check periodically, until cancelled, whether robots may still be logged in."""
        await repeat(self.check, CHECK_PERIOD)

    async def check(self) -> None:
        """Disconnect the robots whose token, or password for this protocol, is no longer valid."""
        await asyncio.gather(*(self._check(robot) for robot, _ in tuple(self._robots.values())))

    async def _check(self, robot: RapyutaRobot) -> None:
        try:
            await self._services.accounts.user_of(robot.identity.token)
            await check_verifier(robot.identity, self._services)
        except (NotAuthenticated, NotPermitted) as error:
            self._dismiss(robot, error)
        except Unavailable:
            return  # it cannot be checked now, as the store is unreachable: the right remains

    def _dismiss(self, robot: RapyutaRobot, reason: PPaaSError) -> None:
        robot.end(reason)
        if robot.carrier is None:
            self._end(robot)
