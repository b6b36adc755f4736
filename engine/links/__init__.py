"""Ends of the control link and of the robot link: servers, places, carried sessions, calls and messages under way."""
