"""Cache of verified tokens, so that not every request waits for the store."""

from storage.records import User
from storage.store_cache import StoreCache


class TokenCache(StoreCache[User]):
    """Users of recently verified tokens, by the hashes of the tokens; of one endpoint.

    Each endpoint is notified when another one changes a user (``SharedLogins.forget``). One that cannot be notified
    accepts a revoked token for the lifetime of an entry.
    """

    def forget_user(self, user_id: str) -> None:
        """Drop all tokens of a user from the cache."""
        self.forget_where(lambda user: user.id == user_id)
