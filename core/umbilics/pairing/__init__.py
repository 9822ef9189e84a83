"""Which umbilics cancel with which, and at what gap."""
