"""Rights watch: ends the sessions of users who lost a right that they had when they connected.

It polls, instead of being notified, so it also sees what another process changed in the store. The caches of tokens and
maps drop what this process changes at once; what another process changes is seen when their entries expire.
"""

import asyncio
from collections import defaultdict

from endpoints.rosbridge.admission import current_access, is_owner
from endpoints.rosbridge.attachment import Attachment
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services
from engine.processes.background import repeat
from engine.service.links.place_link import PlaceLink
from engine.service.robot_sessions import RobotSessions
from engine.specs.joint_maps import owner_by
from ppaas.errors import NotAuthenticated, NotFound, NotPermitted, Unavailable
from storage.records import User

PERIOD = 0.5
"""Interval of the checks [s]."""


class RightsWatch:
    """Ends sessions whose token was revoked or has expired, and places whose map is no longer shared with their user.

    A session at a robot of another user ends when the robot is no longer shared with the client's user; also when it is
    shared for less, whereupon the client connects again and has what is left. A robot that makes a joint map with those
    of another user connects again, and then maps apart from them.

    Parameters
    ----------
    sessions : SessionRegistry
        Sessions of all clients.
    robots : RobotSessions
        Places of the robots.
    services : Services
        Services with the accounts and the maps.
    """

    def __init__(self, sessions: SessionRegistry, robots: RobotSessions, services: Services) -> None:
        self._sessions = sessions
        self._robots = robots
        self._services = services

    async def run(self) -> None:
        """Check all sessions periodically until cancelled."""
        await repeat(self.check, PERIOD)

    async def check(self) -> None:
        """Check all sessions once; a right that cannot be checked now, as its store is unreachable, remains."""
        by_token: defaultdict[str, list[Attachment]] = defaultdict(list)
        by_map: defaultdict[str, set[tuple[str, PlaceLink]]] = defaultdict(set)
        joint: set[tuple[str, PlaceLink]] = set()
        for attachment in self._sessions.attachments():
            by_token[attachment.token].append(attachment)
            place = attachment.place
            for map_id in self._robots.map_ids(place):
                by_map[map_id].add((attachment.owner, place))
            joint.add((attachment.owner, place))
        await asyncio.gather(
            *(self._check_token(token, attachments) for token, attachments in by_token.items()),
            *(self._check_map(map_id, places) for map_id, places in by_map.items()),
            *(self._check_joint_map(user, place) for user, place in joint),
        )

    async def _check_token(self, token: str, attachments: list[Attachment]) -> None:
        try:
            user = await self._services.accounts.user_of(token)
        except NotAuthenticated as error:
            for attachment in attachments:
                attachment.session.closed(error)
        except Unavailable:
            return
        else:
            limited = (one for one in attachments if not is_owner(user, one.owner) or not one.session.access.is_full)
            await asyncio.gather(*(self._check_access(user, attachment) for attachment in limited))

    async def _check_access(self, user: User, attachment: Attachment) -> None:
        """End a session whose user lost rights on the robot; give it those that are new."""
        session, robot = attachment.session, attachment.request.robot
        try:
            access = await current_access(self._services, user, attachment.owner, robot)
            access.check_connect(as_robot=attachment.request.role == "robot")
        except Unavailable:
            return
        except NotFound:
            if attachment.owner != user.id:
                session.closed(NotPermitted(f"robot {robot!r} of {attachment.owner!r} is not shared with {user.id!r}"))
        except NotPermitted as error:
            session.closed(error)
        else:
            if access.includes(session.access):
                session.access = access
            else:  # what it subscribed to and offers may be more than it may have now
                session.closed(Unavailable(f"your rights on robot {robot!r} were changed: connect again"))

    async def _check_map(self, map_id: str, places: set[tuple[str, PlaceLink]]) -> None:
        try:
            head = await self._services.map_cache.head(self._services.map_store, map_id)
        except (NotFound, Unavailable):
            return  # a map in use is not removed, except by another process: what is loaded stays usable
        for user, place in places:
            if not head.readable_by(user):
                await self._robots.let_go(place, NotPermitted(f"map {map_id!r} is no longer shared with {user!r}"))

    async def _check_joint_map(self, user: str, place: PlaceLink) -> None:
        joint = self._robots.joint_map(place)
        if joint is None:
            return
        map_id, owner = joint
        try:
            head = await self._services.map_cache.head(self._services.map_store, map_id)
            if owner_by(head, user) == owner:
                return
        except Unavailable:
            return
        except NotFound:
            pass  # it was removed, and is shared with nobody
        await self._robots.let_go(
            place, Unavailable(f"map {map_id!r} of {owner!r} is no longer shared with {user!r}: connect again")
        )
