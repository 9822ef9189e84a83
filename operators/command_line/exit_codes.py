"""The command's exit codes; docs/batch.md has the table."""

DONE = 0
# Something could not be done: a line on standard error says what.
FAILED = 1
# Wrong arguments, or results that would overwrite something: nothing was done.
REFUSED = 2
# Another batch is at work in the folder of the results: nothing was done; try again later.
BUSY = 3
# Stopped before the end, by Ctrl-C or the wish to end.
INTERRUPTED = 130
