"""What a robot's URDF tells of its body: footprint, height, speeds and sensors."""
