"""Devices of a building: lifts and doors that plug-ins reach by the scheme of a URL."""
