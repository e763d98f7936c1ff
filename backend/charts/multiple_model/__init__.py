"""Charts of multiple-model tracking."""
