"""Detection while it is being set up: what is found, why, what is proposed, what is kept."""
