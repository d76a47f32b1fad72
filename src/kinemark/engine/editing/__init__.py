"""What people say of a trial: journal, edits, and their replay as stages."""
