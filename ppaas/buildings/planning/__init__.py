"""Plans over the floors of a building: drives on floors, joined by lifts, ways and doors."""
