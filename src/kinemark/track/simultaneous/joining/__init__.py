"""Which fragments are one marker's trajectory, and which tracks go on as each other."""
