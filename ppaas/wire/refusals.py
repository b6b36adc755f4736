"""Conversion of refusals received over the network to the errors of ``ppaas.errors``.

A refusal is an HTTP status with a problem (RFC 9457), the code and reason of a WebSocket close frame (RFC 6455; codes
4400 to 4499 are HTTP statuses plus 4000), or the text of a rosbridge ``status``. The error's class follows from the
slug; without a known slug, from the number.
"""

import re

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import (
    Conflict,
    InvalidInput,
    InvalidRobot,
    InvalidZones,
    MessageTooLarge,
    NotAuthenticated,
    NotFound,
    NotPermitted,
    PPaaSError,
    QuotaExceeded,
    RobotFault,
    Unavailable,
    ZoneFault,
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
_STRICT = (
    "authority key identifier", "subject key identifier", "key usage", "keycertsign", "basic constraints",
    "path length given", "path length invalid", "name is empty", "subjectaltname", "certificate version",
)  # fmt: skip
"""Reasons of OpenSSL's strict mode, which Python 3.13 switched on (``ssl.VERIFY_X509_STRICT``)."""

_SLUGGED = re.compile(r"(?P<slug>[a-z]+(?:-[a-z]+)*): (?P<text>.*)", re.DOTALL)


class ReceivedFault(msgspec.Struct):
    """What is wrong with a zone, and where [m]; or with a parameter of a robot file."""

    text: str = ""
    zone: str = ""
    parameter: str = ""
    place: tuple[float, float] | None = None


class ReceivedProblem(msgspec.Struct):
    """Members of a problem (RFC 9457) that are used here."""

    type: str = "about:blank"
    title: str = ""
    detail: str = ""
    status: int | None = None
    faults: list[ReceivedFault] = []


def untrusted(reason: str, option: str = "--ca-file or SSL_CERT_FILE") -> str:
    """Return why the certificate of a server is not trusted, and what to do.

    Parameters
    ----------
    reason : str
        Reason that OpenSSL gives, as ``ssl.SSLCertVerificationError.verify_message``.
    option : str
        What names the authorities to trust.
    """
    if any(words in reason.lower() for words in _STRICT):
        advice = (
            "Python 3.13 and newer trust no certificates without it (RFC 5280): make the authority with the extensions "
            "basicConstraints=critical,CA:TRUE, keyUsage=critical,keyCertSign and subjectKeyIdentifier=hash, and the "
            "certificate of the server with authorityKeyIdentifier=keyid"
        )
    else:
        advice = f"name the file with the certificate of its authority by {option}"
    return f"its certificate is not trusted ({reason}); {advice}"


def error_of_text(text: str, otherwise: type[PPaaSError] = PPaaSError) -> PPaaSError:
    """Return the error of a text ``slug: description``; an error of class ``otherwise`` if the slug is unknown."""
    match = _SLUGGED.fullmatch(text)
    if match:
        error = rebuild(match["slug"], match["text"])
        if error.slug == match["slug"]:
            return error
    return rebuild(otherwise.slug, text)


def error_of_status(status: int, body: bytes = b"") -> PPaaSError:
    """Return the error of an HTTP response that reports a failure.

    Parameters
    ----------
    status : int
        HTTP status, 400 or above.
    body : bytes
        Body of the response; it is used if it is a problem in JSON.
    """
    try:
        problem = from_json(body, ReceivedProblem)
    except (msgspec.DecodeError, UnicodeDecodeError):
        problem = ReceivedProblem()
    text = problem.detail or problem.title or f"HTTP status {status}"
    error = rebuild(re.split(r"[/:#]", problem.type)[-1], text)
    if isinstance(error, InvalidZones):
        error.faults = tuple(ZoneFault(fault.zone, fault.text, fault.place) for fault in problem.faults)
    elif isinstance(error, InvalidRobot):
        error.faults = tuple(RobotFault(fault.parameter, fault.text) for fault in problem.faults)
    return error if type(error) is not PPaaSError else rebuild(_class_of_status(status).slug, text)


def _class_of_status(status: int) -> type[PPaaSError]:
    return _BY_STATUS.get(status, Unavailable if status >= 500 else InvalidInput)


def error_of_close(code: int | None, reason: str = "") -> PPaaSError:
    """Return the error for which the other side closed a WebSocket.

    Parameters
    ----------
    code : int or None
        Code of the close frame; None if the connection broke without one.
    reason : str
        Reason of the close frame.

    Returns
    -------
    PPaaSError
        ``Unavailable`` if the client may connect again.
    """
    if code is not None and 4400 <= code < 4500:
        return error_of_text(reason or f"closed with code {code}", _class_of_status(code - 4000))
    otherwise = _BY_CLOSE_CODE.get(code or 1006, Unavailable)
    return error_of_text(reason or f"the connection was closed (code {code or 1006})", otherwise)
