"""A console on which text from files cannot steer the terminal, whatever prints it."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from waypointctl.display_text import printable_lines


class PrintableConsole(Console):
    """A rich console whose text has no control characters but line breaks; rich's own sequences stay."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Yield what a thing is printed as."""
        for segment in super().render(renderable, options):
            if segment.control or (shown := printable_lines(segment.text)) == segment.text:
                yield segment
            else:
                yield Segment(shown, segment.style)
