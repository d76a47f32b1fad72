"""Gait of files and of a session: settings, walks, comparison, reference bands, exports."""
