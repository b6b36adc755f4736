"""JSON schemas of users, their quotas and usage, and tokens."""

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from endpoints.accounts.tokens import TOKEN_LIFETIME
from endpoints.rest.names import Name
from endpoints.rest.schemas import Number, RequestBody, ResponseBody, TopicGlobs
from engine.rights.globs import MAX_GLOBS, ROBOT_GLOB
from storage.records import Role
from storage.sharing_records import ALL, TokenRole, TokenScope

MAX_LIMIT = 1_000_000_000
"""Largest limit that a user may be given; more than any cloud has."""

MAX_BYTES = 1 << 50
"""Largest limit of stored bytes."""

MIN_LIFETIME = 60.0
MAX_LIFETIME = 366 * 24 * 3600.0
"""Shortest and longest lifetime of a token with a scope [s]."""

MAX_TOKEN_NAME = 100
"""Largest name of a token [characters]."""

MAX_GROUPS = 64
"""Largest number of groups of a user."""

Password = Annotated[str, Field(min_length=8, max_length=1024, examples=["correct horse"])]
RobotGlob = Annotated[str, Field(pattern=f"^{ROBOT_GLOB}$")]
_Count = Annotated[int, Field(strict=True, ge=0, le=MAX_LIMIT)]
_Bytes = Annotated[int, Field(strict=True, ge=0, le=MAX_BYTES)]
_Cores = Annotated[Number, Field(ge=0.0, le=MAX_LIMIT)]


class Credentials(RequestBody):
    """User and password to log in with."""

    user: str = Field(max_length=64, examples=["ann"])
    password: str = Field(max_length=1024, examples=["correct horse"])


class TokenAnswer(ResponseBody):
    """New token."""

    id: str = Field(description="Id of the token, with which it can be revoked")
    token: str
    expires: float = Field(description="Seconds since the epoch")


class TicketAnswer(ResponseBody):
    """New ticket for one handshake."""

    ticket: str = Field(description="Put it into the address of a WebSocket as `ticket`; it is good once")
    expires_in: float = Field(description="Time within which the handshake must begin [s]")


class ScopeAnswer(ResponseBody):
    """Limit of the rights of a token."""

    robots: list[str]
    role: TokenRole
    publish: list[str]
    subscribe: list[str]


class TokenSummary(ResponseBody):
    """Token without its text, which is not stored."""

    id: str
    name: str = Field(description="What a token with a scope is for")
    scope: ScopeAnswer | None = Field(description="Limit of its rights; null if it has all rights of its user")
    created: float = Field(description="Seconds since the epoch; 0 if unknown")
    expires: float = Field(description="Seconds since the epoch")
    current: bool = Field(description="Whether it is the token of this request")


class ScopedTokenRequest(RequestBody):
    """Token for some robots only."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"robots": ["tb*"], "role": "look"}]})

    robots: Annotated[list[RobotGlob], Field(min_length=1, max_length=MAX_GLOBS)] = Field(
        description="Globs of your robots; `OWNER:ROBOT` with two globs for robots that are shared with you"
    )
    role: TokenRole = Field(
        description="`look`, `drive` and `administer` as of shares; `robot`: connect as the robot itself, for a token "
        "that is stored on the robot"
    )
    publish: TopicGlobs | None = Field(default=None, description="As of shares; default: all, and none for `look`")
    subscribe: TopicGlobs = Field(default=["*"], description="As of shares")
    expires_in: Annotated[Number, Field(ge=MIN_LIFETIME, le=MAX_LIFETIME)] = Field(
        default=TOKEN_LIFETIME, description="Time after which it expires [s]"
    )
    name: str = Field(default="", max_length=MAX_TOKEN_NAME, description="What it is for, shown in lists")

    @model_validator(mode="after")
    def _fits_the_role(self) -> Self:
        if self.role == "look" and self.publish:
            raise ValueError("role 'look' publishes nothing: leave out 'publish', or give the role 'drive'")
        return self

    @property
    def scope(self) -> TokenScope:
        """Scope of the token."""
        publish = () if self.role == "look" else ALL if self.publish is None else tuple(self.publish)
        return TokenScope(tuple(self.robots), self.role, publish, tuple(self.subscribe))


class IdentityBody(RequestBody):
    """Somebody for whom the identity provider vouches."""

    issuer: str = Field(min_length=1, max_length=2048, description="URL of the provider, as its tokens name it")
    subject: str = Field(min_length=1, max_length=255, description="Who it is there: `sub` of its tokens")


Groups = Annotated[list[Name], Field(max_length=MAX_GROUPS, description="Groups of users that the user is in")]


def distinct(groups: list[str]) -> tuple[str, ...]:
    """Return groups sorted, each once."""
    return tuple(sorted(set(groups)))


class NewUser(RequestBody):
    """User to create."""

    id: Name
    password: Password
    role: Role = "user"
    groups: Groups = Field([])


class LimitsChange(RequestBody):
    """Changes of a user's own limits; null restores the limit of all users."""

    containers: _Count | None = None
    cores: _Cores | None = None
    robots: _Count | None = None
    maps: _Count | None = None
    plans_per_minute: _Count | None = None
    stored_bytes: _Bytes | None = None
    versions_per_map: _Count | None = None


class UserChange(RequestBody):
    """Changes of a user (JSON merge patch); omitted fields stay unchanged."""

    role: Role | None = None
    password: Password | None = None
    old_password: str | None = Field(
        None,
        max_length=1024,
        description="Current password, needed to change your own password; administrators change others' without it",
    )
    limits: LimitsChange | None = Field(
        None, description="Own limits of the user, set by administrators; null removes all of them"
    )
    rapyuta_password: Password | None = Field(
        None,
        description="Password by which the robots of the user log in by the protocol of Rapyuta, set by "
        "administrators; null lets none do so",
    )
    groups: Groups | None = Field(None, description="Groups of the user, set by administrators; null for none")
    identity: IdentityBody | None = Field(
        None,
        description="Who logs in as this user with the identity provider, set by administrators; null for nobody, "
        "which ends all logins of the user",
    )


class UserAnswer(ResponseBody):
    """User of the cloud."""

    id: str
    role: Role
    groups: list[str]


class LimitsAnswer(ResponseBody):
    """Own limits of a user; null where the limit of all users applies."""

    containers: int | None
    cores: float | None
    robots: int | None
    maps: int | None
    plans_per_minute: int | None
    stored_bytes: int | None
    versions_per_map: int | None


class QuotaAnswer(ResponseBody):
    """Limited resources of a user, as a quota or as usage."""

    containers: int = Field(description="Number of running containers: clones, and one per map for path requests")
    cores: float = Field(description="Total size of these containers")
    robots: int = Field(description="Number of registered robots, connected or not")
    maps: int = Field(description="Number of maps that the user owns")
    plans_per_minute: int = Field(description="Path requests per minute, by REST or to the robots' services")
    stored_bytes: int = Field(description="Size of all files of these maps and of the robots' URDFs [bytes]")
    versions_per_map: int = Field(description="Number of versions of a map; as usage, of the map with the most")


class IdentityAnswer(ResponseBody):
    """Somebody for whom the identity provider vouches."""

    issuer: str
    subject: str


class UserDetail(UserAnswer):
    """User with limits, quota and usage."""

    limits: LimitsAnswer
    identity: IdentityAnswer | None = Field(description="Who logs in as this user with the identity provider")
    rapyuta: bool = Field(description="Whether robots of the user may log in by the protocol of Rapyuta by password")
    quota: QuotaAnswer = Field(description="Quota of the user")
    used: QuotaAnswer = Field(description="Current usage")
