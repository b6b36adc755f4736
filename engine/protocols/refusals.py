"""Refusals: errors as another process receives them, without the texts that only operators may read."""

import logging

from engine.protocols.robot_link import Refusal
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)


def refusal_of(error: PPaaSError) -> Refusal:
    """Return the refusal for an error, whose text may reach clients; a text for operators is logged here."""
    if error.public != str(error):
        logger.warning("%s: %s", error.slug, error)
    return Refusal(error.slug, error.public)
