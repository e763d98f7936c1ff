"""Tracking of manoeuvring aircraft from the plots of a rotating radar."""
