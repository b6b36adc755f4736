"""JSON schemas of logins with an identity provider."""

from typing import Annotated

from pydantic import Field

from endpoints.rest.schemas import RequestBody, ResponseBody
from endpoints.rest.users.schemas import TokenAnswer

MAX_CODE = 4096
"""Longest code of a provider [characters]."""

MAX_JWT = 15_000

Code = Annotated[str, Field(min_length=1, max_length=MAX_CODE)]
Kept = Annotated[str, Field(min_length=32, max_length=128, pattern="^[A-Za-z0-9_-]+$")]


class ProviderAnswer(ResponseBody):
    """Identity provider of the cloud."""

    name: str | None = Field(description="Its name for people; null if the cloud has none")


class LoginStartAnswer(ResponseBody):
    """Login of a browser that begins."""

    url: str = Field(description="Address at the provider where it goes on")
    state: str = Field(description="Compare it with the one in the address when the provider sends the browser back")
    nonce: str = Field(description="Keep it in the browser, for the end of the login")
    verifier: str = Field(description="Keep it in the browser, for the end of the login (PKCE)")


class CodeLogin(RequestBody):
    """End of the login of a browser."""

    code: Code = Field(description="From the address to which the provider has sent the browser")
    iss: str | None = Field(None, max_length=2048, description="From this address, if it is there")
    nonce: Kept = Field(description="From the start of the login")
    verifier: Kept = Field(description="From the start of the login")


class DeviceCodeAnswer(ResponseBody):
    """Login of a device that begins: its person enters a code at the provider."""

    device_code: str = Field(description="For the end of the login")
    verifier: str = Field(description="For the end of the login (PKCE)")
    user_code: str = Field(description="What the person enters")
    verification_uri: str = Field(description="Where")
    verification_uri_complete: str | None = Field(description="The same address with the code, if the provider has it")
    expires_in: float = Field(description="Time within which the person must log in [s]")
    interval: float = Field(description="Least time between two requests for the token [s]")


class DeviceLogin(RequestBody):
    """End of the login of a device."""

    device_code: Code
    verifier: Kept


class LoginPendingAnswer(ResponseBody):
    """Login of a device whose person has not logged in yet."""

    slower: bool = Field(description="Whether to wait 5 s longer between requests from now on")


class AccessToken(RequestBody):
    """Access token of the identity provider."""

    access_token: str = Field(min_length=1, max_length=MAX_JWT, description="JWT whose audience is this cloud")


class ProvidedToken(TokenAnswer):
    """New token of somebody whom the identity provider vouches for."""

    user: str
    logout_url: str | None = Field(
        default=None, description="Address at which the login at the provider ends, for a browser that logs out"
    )
