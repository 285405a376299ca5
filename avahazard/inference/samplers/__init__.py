"""Draws of the posterior, and whether they have converged."""
