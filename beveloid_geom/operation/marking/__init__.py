"""Where flanks come near each other over the roll, as marking compound shows it."""
