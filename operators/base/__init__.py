"""What all of the operators stand on: errors, words, units, notices."""
