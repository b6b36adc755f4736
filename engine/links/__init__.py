"""Ends of the robot link that endpoints and containers share: open calls, unacknowledged messages."""
