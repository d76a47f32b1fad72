"""Whether a trial's cameras fit each other: start times, swapped cameras, axes of pixels."""
