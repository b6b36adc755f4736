"""Refusals as they cross the wire, back to the errors of ``ppaas.errors``.

A refusal comes as an HTTP status with a problem (RFC 9457), as the code and reason with which a WebSocket is closed
(RFC 6455; 4400–4499 are HTTP's statuses plus 4000), or as the text of a rosbridge ``status``. Where it carries the
slug of an error, the slug decides; else the number does.
"""

import re

import msgspec

from ppaas.errors import (
    Conflict,
    InvalidInput,
    MessageTooLarge,
    NotAuthenticated,
    NotFound,
    NotPermitted,
    PPaaSError,
    QuotaExceeded,
    Unavailable,
    rebuild,
)

_BY_STATUS: dict[int, type[PPaaSError]] = {
    400: InvalidInput,
    401: NotAuthenticated,
    403: NotPermitted,
    404: NotFound,
    409: Conflict,
    413: MessageTooLarge,
    422: InvalidInput,
    429: QuotaExceeded,
}
_BY_CLOSE_CODE: dict[int, type[PPaaSError]] = {
    1002: InvalidInput,
    1003: InvalidInput,
    1007: InvalidInput,
    1008: NotPermitted,
    1009: MessageTooLarge,
}
_SLUGGED = re.compile(r"(?P<slug>[a-z]+(?:-[a-z]+)*): (?P<text>.*)", re.DOTALL)


class ReceivedProblem(msgspec.Struct):
    """The members of a problem (RFC 9457) that are read here."""

    type: str = "about:blank"
    title: str = ""
    detail: str = ""
    status: int | None = None


def error_of_text(text: str, otherwise: type[PPaaSError] = PPaaSError) -> PPaaSError:
    """Return the error of a text ``slug: what is wrong``; without a known slug one of ``otherwise``."""
    match = _SLUGGED.fullmatch(text)
    if match:
        error = rebuild(match["slug"], match["text"])
        if error.slug == match["slug"]:
            return error
    return rebuild(otherwise.slug, text)


def error_of_status(status: int, body: bytes = b"") -> PPaaSError:
    """Return the error of an HTTP answer that is no success.

    Parameters
    ----------
    status : int
        400 or more.
    body : bytes
        A problem as JSON, or anything.
    """
    try:
        problem = msgspec.json.decode(body, type=ReceivedProblem)
    except (msgspec.DecodeError, UnicodeDecodeError):
        problem = ReceivedProblem()
    text = problem.detail or problem.title or f"HTTP status {status}"
    error = rebuild(re.split(r"[/:#]", problem.type)[-1], text)
    return error if type(error) is not PPaaSError else rebuild(_class_of_status(status).slug, text)


def _class_of_status(status: int) -> type[PPaaSError]:
    return _BY_STATUS.get(status, Unavailable if status >= 500 else InvalidInput)


def error_of_close(code: int | None, reason: str = "") -> PPaaSError:
    """Return why the other side closed a WebSocket.

    Parameters
    ----------
    code : int or None
        Of the close frame; None if the connection broke without one.
    reason : str
        Of the close frame.

    Returns
    -------
    PPaaSError
        ``Unavailable`` where it is worth connecting again.
    """
    if code is not None and 4400 <= code < 4500:
        return error_of_text(reason or f"closed with code {code}", _class_of_status(code - 4000))
    otherwise = _BY_CLOSE_CODE.get(code or 1006, Unavailable)
    return error_of_text(reason or f"the connection was closed (code {code or 1006})", otherwise)
