"""Secret by which an endpoint knows that a container is of a place: derived from the endpoint's own."""

import hmac


def place_secret(secret: str, place: str, generation: int) -> str:
    """Return the secret for a container of a place.

    Parameters
    ----------
    secret : str
        Secret of the endpoint, which the endpoint and the master know.
    place : str
        Name of the place.
    generation : int
        Number of the container among the place's containers.
    """
    return hmac.digest(secret.encode(), f"{generation} {place}".encode(), "sha256").hex()
