"""Areas and curves on which no umbilic stands by itself."""
