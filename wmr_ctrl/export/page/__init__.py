"""One HTML file in which the compiled closed loop runs live; see docs/page.md."""

from .write import write_page as write_page

__all__ = ["write_page"]
