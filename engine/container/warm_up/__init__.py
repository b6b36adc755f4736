"""Warm-up: modules that the fork server loads and runs once, before it forks the first container."""
