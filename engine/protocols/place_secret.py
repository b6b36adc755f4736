"""Secret by which an endpoint knows that a container is of a place: derived from the endpoint's own."""

import hmac


def place_secret(secret: str, place: str) -> str:
    """Return the secret for the containers of a place.

    Parameters
    ----------
    secret : str
        Secret of the endpoint, which the endpoint and the master know.
    place : str
        Name of the place.
    """
    return hmac.digest(secret.encode(), place.encode(), "sha256").hex()
