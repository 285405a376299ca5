"""The block on its path: arrays in, arrays out; no files, no random numbers."""
