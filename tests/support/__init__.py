"""What tests share: scenes, operators, files, and where the real recordings are."""
