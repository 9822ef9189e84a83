"""What everything stands on: errors, progress, threads, buffers, options."""
