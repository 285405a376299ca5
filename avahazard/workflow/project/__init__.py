"""The parts of `run`: the file of a project, its models, its answers."""
