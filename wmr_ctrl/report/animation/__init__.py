"""The robot on its path as moving pictures: a page, a GIF or a film."""
