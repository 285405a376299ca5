"""Worlds whose truth is known, made by an integrator of their own: nothing here uses the product."""
