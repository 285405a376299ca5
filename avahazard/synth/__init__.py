"""Synthetic datasets with known truth, by an integrator that is independent of the program's."""
