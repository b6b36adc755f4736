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
from ppaas.errors import NotAuthenticated, NotFound, NotPermitted, Unavailable
from storage.records import User

PERIOD = 0.5
"""Interval of the checks [s]."""


class RightsWatch:
    """Ends sessions whose token was revoked or has expired.

    A session at a robot of another user ends when the robot is no longer shared with the client's user; also when it is
    shared for less, whereupon the client connects again and has what is left.

    Parameters
    ----------
    sessions : SessionRegistry
        Sessions of all clients.
    services : Services
        Services with the accounts.
    """

    def __init__(self, sessions: SessionRegistry, services: Services) -> None:
        self._sessions = sessions
        self._services = services

    async def run(self) -> None:
        """Check all sessions periodically until cancelled."""
        await repeat(self.check, PERIOD)

    async def check(self) -> None:
        """Check all sessions once; a right that cannot be checked now, as its store is unreachable, remains."""
        by_token: defaultdict[str, list[Attachment]] = defaultdict(list)
        for attachment in self._sessions.attachments():
            by_token[attachment.token].append(attachment)
        await asyncio.gather(*(self._check_token(token, attachments) for token, attachments in by_token.items()))

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
