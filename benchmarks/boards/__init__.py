"""``ppaas bench boards``: what the clients of microcontrollers cost a board."""
