"""What is to be known of a design: errors, warnings, notes, advice."""
