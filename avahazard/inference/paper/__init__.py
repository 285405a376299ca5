"""The methods of Ancey (2005): apparent friction, its density, least squares, two samplers."""
