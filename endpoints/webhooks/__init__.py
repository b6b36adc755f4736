"""Webhooks: events of a cloud that are sent to the URLs of users, signed, and retried until they arrive."""
