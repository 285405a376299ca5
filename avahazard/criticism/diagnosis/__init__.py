"""Which effect is missing: full refits, the verdict, and what to measure next."""
