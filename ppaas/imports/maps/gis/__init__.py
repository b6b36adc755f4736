"""Rasters and coordinate systems of GIS programs, read by GDAL and PROJ through rasterio."""
