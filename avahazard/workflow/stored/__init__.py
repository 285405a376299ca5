"""Models in the database: how they are kept, found again and told."""
