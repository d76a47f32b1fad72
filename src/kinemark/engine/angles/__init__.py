"""Joint angles of a trial: by `kinemark angles`, and as a stage of a session's trial."""
