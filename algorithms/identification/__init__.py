"""Which plots of separated radars belong to one target."""
