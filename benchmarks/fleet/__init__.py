"""Plans of fleets."""
