"""Refusals: errors as another process receives them, without the texts that only operators may read."""

import logging

import msgspec

from ppaas.errors import PPaaSError, Queued, QuotaExceeded, Starting, rebuild

logger = logging.getLogger(__name__)


class Refusal(msgspec.Struct, frozen=True):
    """An error that is sent to another process.

    Parameters
    ----------
    slug, text : str
    retry_after : float, optional
        Delay of a ``QuotaExceeded`` or a ``Starting`` [s].
    position : int
        Position of a ``Queued``; 0 for other errors.
    """

    slug: str
    text: str
    retry_after: float | None = None
    position: int = 0


def refusal_of(error: PPaaSError) -> Refusal:
    """Return the refusal for an error, whose text may reach clients; a text for operators is logged here."""
    if error.public != str(error):
        logger.warning("%s: %s", error.slug, error)
    retry_after = error.retry_after if isinstance(error, QuotaExceeded | Starting) else None
    position = error.position if isinstance(error, Queued) else 0
    return Refusal(error.slug, error.public, retry_after, position)


def error_of(refusal: Refusal) -> PPaaSError:
    """Return the error that another process sent; a `PPaaSError` if its slug is unknown."""
    error = rebuild(refusal.slug, refusal.text)
    if isinstance(error, QuotaExceeded | Starting):
        error.retry_after = refusal.retry_after
    elif isinstance(error, Queued):
        error.position = refusal.position
    return error
