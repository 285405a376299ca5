"""Friction laws, likelihood and samplers."""
