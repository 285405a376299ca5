"""Faults, many users, upgrades and bad input over the whole product (docs/trust.md)."""
