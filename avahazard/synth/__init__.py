"""Worlds whose truth is known, made by an integrator of their own, not the product's."""
