"""The command filter's statements against adversaries: see ``__main__``."""
