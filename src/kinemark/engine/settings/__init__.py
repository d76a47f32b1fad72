"""`session.toml`: what a user says about a recording, checked, with errors that name the key and what it may be."""

import lazy_loader

# The names stand in __init__.pyi; each is imported when it is first used: what there is needs no session's tables.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
