"""``ppaas bench wire``: what endpoints cost the frames that pass through them, beside bare programs."""
