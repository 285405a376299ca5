"""Which candidate effects the data ask for, against what chance alone would show."""
