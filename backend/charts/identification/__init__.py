"""Charts of the identification family."""
