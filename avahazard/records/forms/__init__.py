"""The forms of a row, one file each, as the contract names their columns (section 1)."""
