"""Journeys of robots over the floors of buildings, in the process of the master."""
