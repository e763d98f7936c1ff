"""Life cycle of tracks."""
