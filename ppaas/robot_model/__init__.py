"""Robot models from URDF files: footprint, height, speed limits and sensors."""
