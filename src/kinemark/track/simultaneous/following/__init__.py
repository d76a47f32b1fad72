"""The first pass: images become tracks, which are followed from frame to frame, and confirmed."""
