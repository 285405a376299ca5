"""Maps: lines and terrain models in, map files out. Needs the packages of the extra `gis`."""
