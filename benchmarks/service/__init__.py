"""Bench of the service: waiting times of a user, from the start of a cloud to driving robots."""
