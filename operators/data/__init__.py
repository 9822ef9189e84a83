"""What is kept in the file and in the preferences: settings, results, plans."""
