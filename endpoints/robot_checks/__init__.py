"""Checks of robot files before they are stored: what the clone would refuse, is refused at once."""
