"""The benchmark on synthetic datasets: what `diagnose` finds where the truth is known."""
