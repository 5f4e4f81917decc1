"""What is given: tools, members, the pair and its errors, and design files."""
