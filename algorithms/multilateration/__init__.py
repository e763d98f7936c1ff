"""Passive time-difference tracking with altitude as an observation (paper 1)."""
