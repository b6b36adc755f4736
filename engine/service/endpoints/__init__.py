"""Endpoints as the master serves them: their registration, their clients, and their calls."""
