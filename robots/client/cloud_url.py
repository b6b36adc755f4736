"""URL of a cloud, for the REST client, the WebSocket client and the commands, and paths of its REST service."""

from dataclasses import dataclass
from urllib.parse import quote, urlsplit

from ppaas.errors import InvalidInput, NotAuthenticated

_SECURE = {"http": False, "ws": False, "https": True, "wss": True}


@dataclass(frozen=True, slots=True)
class CloudUrl:
    """Parts of the URL of a cloud.

    Parameters
    ----------
    secure : bool
        Whether connections use TLS.
    netloc : str
        Host and port.
    path : str
        Path below which the cloud is served by a proxy; without a slash at its end, and usually empty.
    """

    secure: bool
    netloc: str
    path: str

    @classmethod
    def parse(cls, url: str) -> "CloudUrl":
        """Return the parts of a URL.

        Raises
        ------
        InvalidInput
            The URL has another form.
        """
        try:
            parts = urlsplit(url)
            good = parts.scheme in _SECURE and parts.hostname and parts.port != 0 and url.isascii()
        except ValueError:
            good = False
        if not good or any(character <= " " for character in url):
            raise InvalidInput(
                f"URL of the cloud must have the form http://host:port, perhaps with a path, not {url!a}"
            )
        if parts.username is not None or parts.query or parts.fragment:
            raise InvalidInput(
                "URL of the cloud must end with its path: give the token by --token or PPAAS_TOKEN, or as an argument"
            )
        return cls(_SECURE[parts.scheme], parts.netloc, parts.path.rstrip("/"))


def bearer(token: str) -> dict[str, str]:
    """Return the header that carries a token, which addresses must not: servers and proxies log them (RFC 6750, 5.3).

    Raises
    ------
    NotAuthenticated
        The token has characters that no token has.
    """
    if not (token.isascii() and token.isprintable()):
        raise NotAuthenticated("the token has characters that no token has; log in again")
    return {"Authorization": f"Bearer {token}"}


def check_redirect(url: str, status: int, location: str | None) -> None:
    """Raise ``InvalidInput`` if a response redirects: the token is for the cloud of the URL alone.

    Parameters
    ----------
    url : str
        URL of the request; its query is not shown.
    status : int
        HTTP status of the response.
    location : str, optional
        Where it redirects to.
    """
    if 300 <= status < 400:
        known = f" to {location.partition('?')[0]!a}" if location else ""
        raise InvalidInput(f"{url.partition('?')[0]} redirects{known}: give the URL of the cloud itself, perhaps https")


def path_of(*parts: str) -> str:
    """Return the path of a resource, such as ``/v1/maps/office``. The cloud, not this function, checks the names."""
    return "/v1/" + "/".join(quote(part, safe="", errors="surrogateescape") for part in parts)
