"""Results on disk: a netCDF file for each case, and one collected from them for each study."""
