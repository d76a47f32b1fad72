"""When cameras take their images: delays, read-outs and uneven times."""
