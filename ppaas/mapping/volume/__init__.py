"""3D mapping: voxel volumes built from point clouds and depth images, as OctoMap and its ``octomap_server`` do."""
