"""Off-screen pictures and page layout. Nothing here knows about gears."""
