"""Draw the executive's state machine from its table, as docs/executive.md.

python docs/executive.py
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable
from pathlib import Path

from waypointctl.flight.executive.state_machine import TRANSITIONS, UPRIGHT, Signal
from waypointctl.log.messages import Mode

PAGE = Path(__file__).resolve().parent / "executive.md"

TEXT = """\
# The executive on board

<!-- Written by `python docs/executive.py` from waypointctl/flight/executive/state_machine.py: do not edit. -->

The robot is in one mode at a time, and a signal changes the mode. Telemetry, the log and the display show the mode:

```console
$ waypointctl run missions/hold-and-resume.yaml
```

[commands.md](commands.md) describes what each command does, and the rules that a mission's `onboard` block sets. In the
diagram `upright` stands for every mode except `fallen`. A signal that a mode has no transition for is a bug: the
program stops with an error.

```mermaid
stateDiagram-v2
    [*] --> idle
{arrows}
```

| mode | the robot is |
|---|---|
{modes}

| signal | given when | from | to |
|---|---|---|---|
{signals}
"""


def page() -> str:
    """Return the page as the table has it now."""
    modes, signals = _meanings(Mode), _meanings(Signal)
    return TEXT.format(
        arrows="\n".join(_arrows()),
        modes="\n".join(f"| {mode} | {modes[mode.name]} |" for mode in Mode),
        signals="\n".join(_row(signal, signals[signal.name]) for signal in Signal),
    )


def _meanings(kind: type[Mode] | type[Signal]) -> dict[str, str]:
    """Return the comment of each member in the source."""
    source = inspect.getsource(kind)
    found = re.findall(r"^    ([A-Z_]+) = \"(\w+)\"  # (.+)$", source, re.MULTILINE)
    assert len(found) == len(kind)
    return {name: meaning for name, _, meaning in found}


def _row(signal: Signal, meaning: str) -> str:
    (after,) = {mode for (_, given), mode in TRANSITIONS.items() if given is signal}
    return f"| {signal} | {meaning} | {_sources(_from(signal))} | {after} |"


def _sources(modes: Iterable[Mode]) -> str:
    chosen = set(modes)
    return "upright" if chosen == UPRIGHT else ", ".join(mode for mode in Mode if mode in chosen)


def _from(signal: Signal) -> set[Mode]:
    return {mode for mode, given in TRANSITIONS if given is signal}


def _arrows() -> Iterable[str]:
    """Yield the arrows: one for all signals that lead from one mode to another."""
    labels: dict[tuple[str, str], list[str]] = {}
    for (mode, signal), after in TRANSITIONS.items():
        origin = "upright" if _from(signal) == UPRIGHT else mode.value
        names = labels.setdefault((origin, after.value), [])
        if signal.value not in names:
            names.append(signal.value)
    order = ["upright", *(mode.value for mode in Mode)]
    for (origin, after), names in sorted(labels.items(), key=lambda entry: [order.index(end) for end in entry[0]]):
        yield f"    {origin} --> {after}: {', '.join(names)}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
