"""What the use cases return: frozen dataclasses, the same as their JSON, as frames and pictures."""
