"""Cases of the shift law: files, the virtual laboratory, reports."""
