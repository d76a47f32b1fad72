"""The commands, those together that need the same parts of the library; each is imported when it is called."""
