"""The use cases, which join the parts; also the Python API."""
