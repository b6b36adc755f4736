"""Files of maps: YAML beside an image (PGM or PNG), and MovingAI's benchmarks."""
