"""Files of the command line: found, opened, guarded and written."""
