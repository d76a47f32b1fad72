"""What a session's file is called, and how a first one marks what it wants."""

FILE = "session.toml"
MARK = "?"
"""First sign of a comment that is a setting whose value is wanted."""
