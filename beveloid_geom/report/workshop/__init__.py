"""Results for workshop and measuring room in words."""
