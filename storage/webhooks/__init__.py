"""Webhooks of users, and the deliveries that wait or could not be made."""
