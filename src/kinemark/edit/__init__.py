"""What a person said of a trial, applied to it: identities by witnesses, then values, then what the end shall be."""
