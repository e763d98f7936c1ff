"""Charts of forward scatter."""
