"""Refusals: errors as another process receives them, without the texts that only operators may read."""

import logging

import msgspec

from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)


class Refusal(msgspec.Struct, frozen=True):
    """An error that is sent to another process."""

    slug: str
    text: str


def refusal_of(error: PPaaSError) -> Refusal:
    """Return the refusal for an error, whose text may reach clients; a text for operators is logged here."""
    if error.public != str(error):
        logger.warning("%s: %s", error.slug, error)
    return Refusal(error.slug, error.public)
