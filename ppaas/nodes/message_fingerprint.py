"""Fingerprint of a message, by which the cloud and a robot recognize the same message."""

from hashlib import blake2b

from ppaas.messages import encode
from ppaas.messages.base.message import Message


def fingerprint(topic: str, message: Message) -> str:
    """Return a hash of topic and content: equal for the same message, wherever it was decoded."""
    return blake2b(topic.encode() + b"\0" + encode(message), digest_size=8).hexdigest()
