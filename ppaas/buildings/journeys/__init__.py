"""Journeys of robots over the floors of a building: from leg to leg, by lifts, doors and ways."""
