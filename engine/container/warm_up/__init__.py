"""Warm-up: what the fork server loads and runs once before the first container is forked."""
