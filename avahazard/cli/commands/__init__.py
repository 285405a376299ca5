"""One file per command: it parses, calls one use case, and renders."""
