"""Predictions against records: scores, held-out scores, and where a model fails."""
