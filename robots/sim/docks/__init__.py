"""Simulated docks and batteries: chargers with contacts, as lasers see them and robots touch them."""
