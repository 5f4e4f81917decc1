"""Parts of pictures that several figures use."""
