"""How two gears stand to each other: frames, mounting, layouts that close."""
