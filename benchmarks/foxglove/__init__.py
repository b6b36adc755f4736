"""``ppaas bench foxglove``: what viewers of Foxglove cost the cloud."""
