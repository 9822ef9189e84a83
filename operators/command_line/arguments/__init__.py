"""The arguments of the command, as one request."""
