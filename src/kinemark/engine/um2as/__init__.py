"""UM²AS over a session: its flow, files and menu."""
