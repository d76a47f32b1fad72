"""The studio: trials on a screen in the browser; its server, over the engine. Only this folder imports FastAPI."""
