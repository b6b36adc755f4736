"""Endpoint that ignores what the master calls."""


class IgnoredCalls:
    """Implements ``EndpointCalls``."""

    async def ignore(self, *_: object) -> None:
        """Ignore a call."""

    place_closed = hear = fact = displace = ignore
