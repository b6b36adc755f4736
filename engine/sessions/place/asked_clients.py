"""Clients that are asked by other clients: an internal error of one becomes an answer to the other."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from ppaas.errors import PPaaSError, Unavailable

logger = logging.getLogger(__name__)


@contextmanager
def client_asked(offer: str) -> Iterator[None]:
    """Run the part of a client that takes a call or a goal of another one.

    Parameters
    ----------
    offer : str
        What the client offers, for error texts.

    Raises
    ------
    Unavailable
        The client has failed.
    """
    try:
        yield
    except PPaaSError:
        raise
    except Exception as error:
        logger.exception("the client that offers %s failed", offer)
        raise Unavailable(f"the client that offers {offer} failed") from error
