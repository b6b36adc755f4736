"""Docks: how a robot drives to one by what it sees of it, until its battery is charged."""
