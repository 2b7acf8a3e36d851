"""The page for players and clients: a large picture or figure, one count, one verdict, a ring of progress."""
