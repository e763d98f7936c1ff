"""Trajectory-processing algorithms: the mathematics of Filter Room.

Knows nothing of the web, SQL, Plotly or Dask. `registry` finds what is here, `spec` says what an algorithm
declares, `recording` and `result` are what goes in and comes out.
"""
