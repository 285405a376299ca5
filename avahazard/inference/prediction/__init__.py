"""What a model says of stops: draws over scatter, volume error and posterior."""
