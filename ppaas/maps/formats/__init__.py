"""Map files: a YAML record with an image, and the MovingAI benchmarks."""
