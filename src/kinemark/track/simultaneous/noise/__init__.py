"""How noisy images are, and what a calibration leaves in them."""
