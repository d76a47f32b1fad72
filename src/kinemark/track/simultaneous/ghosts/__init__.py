"""Points and images that are no marker's, or more than one marker's."""
