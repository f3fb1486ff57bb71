"""Image sequences from what people have. A module for each kind of source: open_...(path, options) -> Source."""
