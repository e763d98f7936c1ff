"""Where, when and how fast a target crosses the base line of a forward-scatter radar, from Doppler frequencies."""
