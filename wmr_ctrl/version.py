"""Version of the package, alone in a file that everything may import."""

__version__ = "1.0.0"
