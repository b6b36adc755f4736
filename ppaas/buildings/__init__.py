"""Buildings: floors that are maps, and the lifts, doors, stairs and ramps between and on them."""
