"""Buildings: floors, which are maps, and the lifts, doors, ways and docks on them."""
