"""Transport of robots with DDS, on ``cyclonedds``: topics with any vendor, no services."""
