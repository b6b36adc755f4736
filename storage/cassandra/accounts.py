"""Users and their tokens in Cassandra."""

from contextlib import suppress
from typing import Any

from ppaas.errors import Conflict, NotFound
from storage.cassandra.connection.session import CassandraSession, Write
from storage.cassandra.sorted_rows import SortedRows
from storage.encoding import decode, decode_readable, encode
from storage.names import check_name
from storage.records import Token, User
from storage.sharing_records import ProvidedIdentity

_USER = "SELECT record, generation, epoch, kept_token FROM users WHERE shard = 0 AND id = ?"
_TOKEN = "SELECT user, epoch, expires, record, WRITETIME(user) AS written FROM tokens WHERE hash = ?"

_NOT_OF_USER = "DELETE FROM tokens_by_user WHERE user = ? AND hash = ?"
_NOT_EXPIRING = "DELETE FROM tokens_by_expiry WHERE shard = 0 AND expires = ? AND hash = ?"
_OF_USER = SortedRows("tokens_by_user", "user = ?", "hash", "hash DESC")

_LIST = "INSERT INTO users_by_identity (issuer, subject, user) VALUES (?, ?, ?)"
_ALL, _ALL_LISTED = ("-", "-"), "-"
"""Row that says that the users of before this table are in it: no issuer and no user has such a name."""


class CassandraAccounts:
    """A ``UserStore`` in Cassandra, without ``remove_user``.

    The row of a removed user stays, with an empty record: its numbers keep the user's old rows invalid.
    """

    _session: CassandraSession
    _are_identities_listed = False

    # -- users ---------------------------------------------------------------------------------------------------------

    def add_user(self, user: User) -> None:
        """Add a user; ``Conflict`` if the id is taken."""
        check_name("user", user.id)
        insert, data = "UPDATE users SET record = ? WHERE shard = 0 AND id = ? IF record = ?", encode(user)
        self._list_identity(user)
        while not (row := self._session.row(_USER, user.id)) or not row.record:
            if self._session.write_if(insert, data, user.id, row and row.record):
                return
        raise Conflict(f"user {user.id!r} already exists: choose another id")

    def user(self, user_id: str) -> User:
        """Return a user; ``NotFound`` if it does not exist."""
        check_name("user", user_id)
        return decode(self._known_user(user_id).record, User, f"users/{user_id}")

    def users(self, *, after: str = "", limit: int | None = None) -> list[User]:
        """Return users, sorted by id."""
        rows = self._session.rows("SELECT id, record FROM users WHERE shard = 0 AND id > ?", after)
        return decode_readable(((row.record, f"users/{row.id}") for row in rows if row.record), User, limit)

    def user_with_identity(self, identity: ProvidedIdentity) -> User:
        """Return the user of an identity; ``NotFound`` if none has it."""
        self._index_identities()
        query = "SELECT user FROM users_by_identity WHERE issuer = ? AND subject = ?"
        for row in self._session.rows(query, identity.issuer, identity.subject):
            with suppress(NotFound):
                user = self.user(row.user)
                if user.identity == identity:
                    return user
        raise NotFound("user of identity", identity.subject)

    def change_user(self, user: User, *, keep_token: str | None = None) -> None:
        """Replace a user; a new password removes all of the user's tokens but one."""
        check_name("user", user.id)
        change = """UPDATE users SET record = ?, epoch = ?, kept_token = ? WHERE shard = 0 AND id = ?
                    IF record = ? AND epoch = ?"""
        data = encode(user)
        self._list_identity(user)
        while True:
            row = self._known_user(user.id)
            epoch, kept = row.epoch, row.kept_token or ""
            renewed = decode(row.record, User, f"users/{user.id}").password_hash != user.password_hash
            if renewed:
                epoch, kept = (epoch or 0) + 1, self._token_to_keep(user.id, keep_token)
            if self._session.write_if(change, data, epoch, kept, user.id, row.record, row.epoch):
                break
        self._unlist_identity(user.id, row.record)
        if renewed:
            self._sweep_tokens(user.id)

    # -- tokens --------------------------------------------------------------------------------------------------------

    def add_token(self, token: Token) -> None:
        """Store a token; ``NotFound`` if its user does not exist."""
        check_name("token", token.hash)
        check_name("user", token.user)
        epoch = self._known_user(token.user).epoch or 0
        expires = token.expires + 0.0  # -0 would come before 0
        row = "INSERT INTO tokens (hash, user, epoch, expires, record) VALUES (?, ?, ?, ?, ?)"
        self._session.write_batch(
            [
                *self._stale_index_deletions(token),
                (row, (token.hash, token.user, epoch, expires, encode(token))),
                ("INSERT INTO tokens_by_user (user, hash) VALUES (?, ?)", (token.user, token.hash)),
                ("INSERT INTO tokens_by_expiry (shard, expires, hash) VALUES (0, ?, ?)", (expires, token.hash)),
            ]
        )

    def token(self, token_hash: str) -> Token:
        """Return a token, expired or not; ``NotFound`` if it does not exist."""
        check_name("token", token_hash)
        row = self._session.row(_TOKEN, token_hash)
        if row is None or not _is_valid(token_hash, row, self._session.row(_USER, row.user)):
            raise NotFound("token", token_hash)
        return decode(row.record, Token, f"tokens/{token_hash}")

    def tokens(self, user_id: str, *, after: str = "", limit: int | None = None) -> list[Token]:
        """Return the tokens of a user, sorted by hash."""
        check_name("user", user_id)
        user = self._session.row(_USER, user_id)
        found = self._session.rows("SELECT hash FROM tokens_by_user WHERE user = ? AND hash > ?", user_id, after)
        rows = ((row.hash, self._session.row(_TOKEN, row.hash)) for row in found)
        mine = ((key, row) for key, row in rows if row and row.user == user_id and _is_valid(key, row, user))
        return decode_readable(((row.record, f"tokens/{key}") for key, row in mine), Token, limit)

    def remove_token(self, token_hash: str) -> None:
        """Remove a token; ``NotFound`` if it does not exist."""
        self.token(token_hash)
        self._session.write_batch(self._token_deletions(token_hash))

    def remove_tokens(self, *, expired_before: float) -> int:
        """Remove the tokens that expired before a time [s since the epoch]; return their number."""
        query = "SELECT expires, hash FROM tokens_by_expiry WHERE shard = 0 AND expires < ?"
        expired = list(self._session.rows(query, expired_before + 0.0))
        for row in expired:
            self._session.write_batch(self._token_deletions(row.hash)[:-1])
        if expired:  # by one range, which covers earlier calls' ranges
            delete = "DELETE FROM tokens_by_expiry WHERE shard = 0 AND expires <= ?"
            self._session.write(delete, expired[-1].expires)
        return len(expired)

    # -- internals -----------------------------------------------------------------------------------------------------

    def _known_user(self, user_id: str) -> Any:
        row = self._session.row(_USER, user_id)
        if row is None or not row.record:
            raise NotFound("user", user_id)
        return row

    def _end_generation(self, user_id: str) -> int:
        """Remove a user and invalidate all its rows in one write; return the generation of these rows."""
        check_name("user", user_id)
        remove = """UPDATE users SET record = 0x, kept_token = '', generation = ?, epoch = ?
                    WHERE shard = 0 AND id = ? IF record = ? AND generation = ? AND epoch = ?"""
        while True:
            row = self._known_user(user_id)
            after = (row.generation or 0) + 1, (row.epoch or 0) + 1
            if self._session.write_if(remove, *after, user_id, row.record, row.generation, row.epoch):
                self._unlist_identity(user_id, row.record)
                return row.generation or 0

    def _list_identity(self, user: User) -> None:
        if user.identity is not None:
            self._session.write(_LIST, user.identity.issuer, user.identity.subject, user.id)

    def _unlist_identity(self, user_id: str, before: bytes) -> None:
        """List a user no more by the identity of an earlier record, unless it is the one of the record now."""
        earlier = _identity_in(before, user_id)
        if earlier is None or self._identity_now(user_id) == earlier:
            return
        remove = "DELETE FROM users_by_identity WHERE issuer = ? AND subject = ? AND user = ?"
        self._session.write(remove, earlier.issuer, earlier.subject, user_id)
        if self._identity_now(user_id) == earlier:  # another client has bound it again meanwhile
            self._session.write(_LIST, earlier.issuer, earlier.subject, user_id)

    def _identity_now(self, user_id: str) -> ProvidedIdentity | None:
        row = self._session.row(_USER, user_id)
        return None if row is None or not row.record else _identity_in(row.record, user_id)

    def _index_identities(self) -> None:
        """List all users by their identities, unless that was done: the table may be newer than they are."""
        if self._are_identities_listed:
            return
        if self._session.row("SELECT user FROM users_by_identity WHERE issuer = ? AND subject = ?", *_ALL) is None:
            for user in self.users():
                self._list_identity(user)
            self._session.write(_LIST, *_ALL, _ALL_LISTED)
        self._are_identities_listed = True

    def _sweep_tokens(self, user_id: str) -> None:
        """Remove the tokens of a user from earlier epochs, except the one that was kept."""
        user = self._session.row(_USER, user_id)
        for row in self._session.rows("SELECT hash FROM tokens_by_user WHERE user = ?", user_id):
            token = self._session.row(_TOKEN, row.hash)
            if token and token.user == user_id and not _is_valid(row.hash, token, user):
                self._session.write_batch(self._token_deletions(row.hash))

    def _token_to_keep(self, user_id: str, token_hash: str | None) -> str:
        """Return the hash if it is a valid token of the user: a removed token must not become valid again."""
        row = None if token_hash is None else self._session.row(_TOKEN, token_hash)
        if row is None or token_hash is None or row.user != user_id:
            return ""
        return token_hash if _is_valid(token_hash, row, self._session.row(_USER, user_id)) else ""

    def _stale_index_deletions(self, token: Token) -> list[Write]:
        """Return deletions of index rows of an earlier token with this hash that the new token does not overwrite."""
        row = self._session.row(_TOKEN, token.hash)
        writes: list[Write] = []
        if row is not None and row.user != token.user:
            writes.append((_NOT_OF_USER, (row.user, token.hash)))
        if row is not None and row.expires != token.expires:
            writes.append((_NOT_EXPIRING, (row.expires, token.hash)))
        return writes

    def _token_deletions(self, token_hash: str) -> list[Write]:
        """Return the deletions of a token and its index rows, the last of them in the list by expiry.

        The list is empty if there is no such token. A token and its index rows are written in one batch, at one time.
        """
        row = self._session.row(_TOKEN, token_hash)
        if row is None:
            return []
        return [
            ("DELETE FROM tokens WHERE hash = ?", (token_hash,)),
            _OF_USER.deletion(self._session, (row.user,), token_hash, row.written),
            (_NOT_EXPIRING, (row.expires, token_hash)),
        ]


def _identity_in(record: bytes, user_id: str) -> ProvidedIdentity | None:
    """Return the identity in a record of a user; None if it has none or is damaged, which is logged."""
    found = decode_readable([(record, f"users/{user_id}")], User)
    return found[0].identity if found else None


def _is_valid(token_hash: str, token: Any, user: Any) -> bool:
    """Return whether a token belongs to its user's current epoch, or was kept when that epoch began."""
    if user is None or not user.record:
        return False
    return bool(token.epoch == (user.epoch or 0) or token_hash == user.kept_token)
