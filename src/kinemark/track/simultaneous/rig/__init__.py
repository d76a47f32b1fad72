"""What the images and the tracks tell of the cameras, and cameras that are put right or left out."""
