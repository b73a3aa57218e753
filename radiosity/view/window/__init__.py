"""The interactive window: the solution to walk around in, gathered wherever the view rests."""

from radiosity.view.window.opening import show, show_solving
from radiosity.view.window.screen import display_available
from radiosity.view.window.viewer import Window

__all__ = ["Window", "display_available", "show", "show_solving"]
