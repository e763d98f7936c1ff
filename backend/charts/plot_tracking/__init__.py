"""Charts of the plot-tracking family."""
