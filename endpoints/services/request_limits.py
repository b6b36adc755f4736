"""Limits of the sizes and times of requests."""

from dataclasses import dataclass

MIB = 1 << 20


@dataclass(frozen=True, slots=True)
class RequestLimits:
    """Limits of the REST service.

    Parameters
    ----------
    max_body : int
        Largest body of a request except uploads and logins [bytes].
    max_login : int
        Largest body of a login [bytes]: the only body that is read before its caller is authenticated.
    max_upload : int
        Largest body of a map upload: its files and the form [bytes].
    max_body_seconds, max_upload_seconds : float
        Time limit for receiving such a body [s].
    max_plan_seconds : float
        Largest time limit of a path request [s].
    """

    max_body: int = 1 * MIB
    max_login: int = 16 << 10
    max_upload: int = 260 * MIB  # a binary PGM of 16384 x 16384 cells, zones and YAML
    max_body_seconds: float = 30.0
    max_upload_seconds: float = 300.0
    max_plan_seconds: float = 60.0
