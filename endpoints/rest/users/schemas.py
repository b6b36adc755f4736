"""The JSON of users, of what they may have, and of tokens."""

from typing import Annotated

from pydantic import Field

from endpoints.rest.names import Name
from endpoints.rest.schemas import Number, RequestBody, ResponseBody
from storage.records import Role

MOST = 1_000_000_000
"""More than any cloud has of anything."""

Password = Annotated[str, Field(min_length=8, max_length=1024, examples=["correct horse"])]
_Count = Annotated[int, Field(strict=True, ge=0, le=MOST)]
_Cores = Annotated[Number, Field(ge=0.0, le=MOST)]


class Credentials(RequestBody):
    """What to log in with."""

    user: str = Field(max_length=64, examples=["ann"])
    password: str = Field(max_length=1024, examples=["correct horse"])


class TokenAnswer(ResponseBody):
    """A login."""

    id: str = Field(description="With which it is revoked")
    token: str
    expires: float = Field(description="Seconds since the epoch")


class TokenSummary(ResponseBody):
    """A login, without the token itself: that is not kept."""

    id: str
    created: float = Field(description="Seconds since the epoch; 0 where it was not noted")
    expires: float = Field(description="Seconds since the epoch")
    current: bool = Field(description="Whether it is the one that is used now")


class NewUser(RequestBody):
    """A user to be made."""

    id: Name
    password: Password
    role: Role = "user"


class LimitsChange(RequestBody):
    """What a user may have, where that is not what every user may; null is what every user may."""

    containers: _Count | None = None
    cores: _Cores | None = None
    robots: _Count | None = None
    maps: _Count | None = None
    plans_per_minute: _Count | None = None


class UserChange(RequestBody):
    """What is to change of a user (JSON merge patch); what is left out stays."""

    role: Role | None = None
    password: Password | None = None
    old_password: str | None = Field(
        None, max_length=1024, description="Of who changes the own password; an administrator needs none for others"
    )
    limits: LimitsChange | None = Field(
        None, description="Of the user's own, given by administrators; null takes all of them back"
    )


class UserAnswer(ResponseBody):
    """A user."""

    id: str
    role: Role


class LimitsAnswer(ResponseBody):
    """Limits of a user's own; null where the user may have what every user may."""

    containers: int | None
    cores: float | None
    robots: int | None
    maps: int | None
    plans_per_minute: int | None


class QuotaAnswer(ResponseBody):
    """A number of each thing that is limited."""

    containers: int = Field(description="Clones that run, and planning on a map")
    cores: float = Field(description="Of these containers, together")
    robots: int = Field(description="Robots that are told of, connected or not")
    maps: int = Field(description="Maps that the user owns")
    plans_per_minute: int = Field(description="Paths asked for by REST or of the robot's services")


class UserDetail(UserAnswer):
    """A user, and what the user has of what the user may have."""

    limits: LimitsAnswer
    quota: QuotaAnswer = Field(description="What the user may have")
    used: QuotaAnswer = Field(description="What the user has now")
