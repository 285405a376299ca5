"""The benchmark of worlds: what `diagnose` finds where the truth is known."""
