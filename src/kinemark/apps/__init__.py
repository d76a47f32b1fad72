"""The faces: the command line, the demonstration and the operator's terminal, each a few lines over the engine."""
