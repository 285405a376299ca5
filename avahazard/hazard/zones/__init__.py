"""Speed and pressure along a path for return periods, and zones by limits on them."""
