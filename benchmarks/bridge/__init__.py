"""``ppaas bench bridge``: what a bridge costs a robot."""
