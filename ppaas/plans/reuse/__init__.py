"""Reuse of plans: when a stored plan answers a request, whole or in part."""
