"""Models of flow other than the block: each a program of its own, run as a process."""
