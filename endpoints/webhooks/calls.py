"""Calls of endpoints about webhooks, which the process of the master sends."""

from typing import Protocol


class WebhookCalls(Protocol):
    """Calls of endpoints about webhooks."""

    async def check_target(self, url: str) -> None:
        """Raise ``InvalidParameter`` if a webhook may not have this URL."""
        ...

    async def changed(self, user: str) -> None:
        """Note that the webhooks of a user, or their deliveries, were changed in the store."""
        ...
