"""Input data: tools, members, pair, assembly errors; design files."""
