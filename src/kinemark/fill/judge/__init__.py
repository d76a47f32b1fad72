"""Which method is best for a gap, and how far off it may be: hold-out gaps, expected errors, the choice."""
