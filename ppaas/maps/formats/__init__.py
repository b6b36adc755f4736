"""Map files: a YAML record with an image (PGM or PNG), and the MovingAI benchmarks."""
