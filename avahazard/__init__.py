"""Monte Carlo hazard mapping for avalanche paths, after Ancey (2005)."""

__version__ = "0.1.0"
