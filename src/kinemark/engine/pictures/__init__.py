"""Small pictures of all cameras: made, kept and shown side by side."""
