"""The methods that fill a gap, one a file, and what only they share."""
