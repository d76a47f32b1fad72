"""What a session's file is called."""

FILE = "session.toml"
