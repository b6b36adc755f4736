"""A fabric without a router: it records publications and delivers them to its subscriptions."""

from collections.abc import Callable

import zenoh


class Subscription:
    """A subscription to a key expression."""

    def __init__(self, fabric: "FakeFabric", key: str, callback: Callable[[str, bytes], None]) -> None:
        self._fabric = fabric
        self.key = zenoh.KeyExpr(key)
        self.callback = callback

    def close(self) -> None:
        self._fabric.subscriptions.remove(self)


class FakeFabric:
    """Accepts and matches keys as Zenoh does."""

    def __init__(self) -> None:
        self.published: list[tuple[str, bytes]] = []
        self.subscriptions: list[Subscription] = []

    def publish(self, key: str, payload: bytes) -> None:
        expression = zenoh.KeyExpr(key)
        self.published.append((key, payload))
        for subscription in tuple(self.subscriptions):
            if subscription.key.intersects(expression):
                subscription.callback(key, payload)

    def subscribe(self, key: str, callback: Callable[[str, bytes], None]) -> Subscription:
        subscription = Subscription(self, key, callback)
        self.subscriptions.append(subscription)
        return subscription
