"""What drives the stages: sessions, their settings, the order of the stages, and what is kept of them."""
