"""Made worlds in which the runout of a return period is known, and what intervals hold of it."""
