"""Node ``octomap_server``: 3D maps from point clouds and depth images."""
