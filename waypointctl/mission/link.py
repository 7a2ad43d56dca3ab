"""The link of a mission: delay, jitter, loss, rate and contacts of each direction. What is left out has no effect."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import AfterValidator, Discriminator, Field, Strict, Tag, ValidationInfo, field_validator, model_validator

from waypointctl.mission.checks import alone, file_beside, in_order, jitter_within, times_rise, windows_within
from waypointctl.mission.fields import DAY_S
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.presets import PRESETS, PresetName, over_preset
from waypointctl.mission.quantity import Probability, Quantity
from waypointctl.mission.text_file import moment_of
from waypointctl.units import SIZE_UNITS_BYTES, number_in

Delay: TypeAlias = Annotated[float, Quantity("s", ge=0, le=10 * DAY_S)]
Moment: TypeAlias = Annotated[float, Quantity("s", ge=0, le=1000 * DAY_S)]
FileName: TypeAlias = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(file_beside)]
Node: TypeAlias = Annotated[int, Strict(), Field(ge=0, lt=10**18)]


class DelayAt(FileModel):
    """A row of a table of delays; between two rows the delay changes evenly."""

    at_s: Moment = Field(description="from mission start")
    delay_s: Delay = Field(description="one-way delay of what leaves then")


class Window(FileModel):
    """A time during which messages can be sent."""

    from_s: Moment = Field(description="from mission start")
    to_s: Moment = Field(description="until then the last bit can be sent")


class Bursts(FileModel):
    """Loss in bursts, after Gilbert and Elliott, as netem's 'loss gemodel' has it."""

    p: Probability = Field(description="that the good link is bad for the next message")
    r: Probability = Field(description="that the bad link is good for the next message")
    one_minus_h: Probability = Field(1.0, description="that a message is lost while the link is bad (1-h)")
    one_minus_k: Probability = Field(0.0, description="that a message is lost while the link is good (1-k)")

    @property
    def share(self) -> float:
        """The share of messages that are lost in the long run."""
        if not self.p + self.r:
            return self.one_minus_k  # it begins good and stays so
        return (self.p * self.one_minus_h + self.r * self.one_minus_k) / (self.p + self.r)


def _moment(text: str) -> str:
    if moment_of(text) is None:
        raise ValueError(f"{text!r} is not a moment of the form 2027/01/31-12:00:00")
    return text


class ContactPlan(FileModel):
    """A contact plan as ION reads it; it gives windows, rates and light times."""

    former_keys: ClassVar[Mapping[str, str]] = {"back": "reverse"}

    file: FileName = Field(description="the plan (ionrc), beside the mission file")
    from_node: Node = Field(description="the node that sends")
    to_node: Node = Field(description="the node that receives")
    reverse: bool = Field(
        False,
        description="the direction is from to_node to from_node; so for `down` where both directions share a plan",
    )
    reference: Annotated[str, AfterValidator(_moment)] | None = Field(
        None, description="mission start as yyyy/mm/dd-hh:mm:ss, for plans with absolute times"
    )

    @property
    def way(self) -> tuple[int, int]:
        """From which node to which."""
        return (self.to_node, self.from_node) if self.reverse else (self.from_node, self.to_node)


def _loss_kind(loss: object) -> str:
    return "bursts" if isinstance(loss, dict | Bursts) else "probability"


Loss: TypeAlias = Annotated[
    Annotated[Probability, Tag("probability")] | Annotated[Bursts, Tag("bursts")], Discriminator(_loss_kind)
]
DelayTable: TypeAlias = Annotated[
    tuple[DelayAt, ...], Field(min_length=1, max_length=10_000), AfterValidator(times_rise)
]
Windows: TypeAlias = Annotated[tuple[Window, ...], Field(min_length=1, max_length=10_000), AfterValidator(in_order)]


class LinkDirection(FileModel):
    """One direction of the link."""

    former_keys: ClassVar[Mapping[str, str]] = {
        "windows_every": "windows_period",
        "windows_every_s": "windows_period_s",
        "duplication": "duplicate",
    }

    delay_s: Delay = Field(0.0, description="one-way delay; beside a contact plan, in place of its ranges")
    delay_table: DelayTable | None = Field(
        None, description="one-way delay that changes with time; constant before the first and after the last row"
    )
    jitter_distribution: Literal["uniform", "normal"] = Field("uniform", description="distribution of the jitter")
    jitter_s: Delay = Field(
        0.0, description="uniform: by how much a delay may differ, at most the delay; normal: its standard deviation"
    )
    jitter_file: FileName | None = Field(
        None, description="measured jitter to draw from: one number of seconds a line, beside the mission file"
    )
    keep_order: bool = Field(True, description="whether messages arrive in the order in which they were sent")
    loss: Loss = Field(0.0, description="of messages on the way: a probability, or in bursts")
    duplicate: Probability = Field(0.0, description="probability that a message arrives twice")
    queue_bytes: Annotated[float, Quantity("bytes", ge=0, le=1e8)] = Field(
        SIZE_UNITS_BYTES["MiB"], description="how much can wait to be sent; what does not fit is lost"
    )
    contact_plan: ContactPlan | None = Field(None, description="windows, rates and delays from a plan in ION's terms")
    rate_bps: Annotated[float, Quantity("bps", ge=1, le=1e12)] | None = Field(
        None, description="transmission rate; without it sending takes no time"
    )
    windows: Windows | None = Field(None, description="when messages can be sent; without them always")
    windows_period_s: Annotated[float, Quantity("s", gt=0, le=1000 * DAY_S)] | None = Field(
        None, description="the windows recur with this period"
    )

    @property
    def has_own_delay(self) -> bool:
        """Whether the delay is set here, and not by a contact plan."""
        return bool(self.delay_s) or self.delay_table is not None or self.contact_plan is None

    @field_validator("delay_table")
    @classmethod
    def _one_delay(cls, table: DelayTable | None, info: ValidationInfo) -> DelayTable | None:
        alone("delay_table", table, {"delay": info.data.get("delay_s")})
        return table

    @field_validator("jitter_s")
    @classmethod
    def _jitter_within_delay(cls, jitter_s: float, info: ValidationInfo) -> float:
        delay_s, table = info.data.get("delay_s"), info.data.get("delay_table")
        if info.data.get("jitter_distribution") != "uniform" or "delay_table" not in info.data:
            return jitter_s  # the normal distribution has no bounds: what would be too early comes at once
        return jitter_within(jitter_s, min(row.delay_s for row in table) if table else delay_s)

    @field_validator("jitter_file")
    @classmethod
    def _one_jitter(cls, name: str | None, info: ValidationInfo) -> str | None:
        alone("jitter_file", name, {"jitter": info.data.get("jitter_s")})
        return name

    @field_validator("rate_bps", "windows")
    @classmethod
    def _one_plan(cls, value: object, info: ValidationInfo) -> object:
        alone(str(info.field_name).removesuffix("_bps"), value, {"contact_plan": info.data.get("contact_plan")})
        return value

    @field_validator("windows_period_s")
    @classmethod
    def _all_windows_in_time(cls, every_s: float | None, info: ValidationInfo) -> float | None:
        if "windows" in info.data:  # else they are wrong already
            windows_within(every_s, info.data["windows"])
        return every_s


class Link(FileModel):
    """The link between operator and robot. Keys of `up` and `down` may be written here, for both directions."""

    keys_for_each: ClassVar[tuple[str, ...]] = ("up", "down")

    preset: PresetName | None = Field(
        None, description="a link by its name; values beside it replace those of the preset"
    )
    up: LinkDirection = Field(LinkDirection(), description="commands, from the operator to the robot")
    down: LinkDirection = Field(
        LinkDirection(), description="telemetry and acknowledgements, from the robot to the operator"
    )

    @model_validator(mode="before")
    @classmethod
    def _no_bare_word(cls, given: Any) -> Any:
        """Refuse a bare word, with a hint on how a preset is written."""
        if isinstance(given, str):
            raise ValueError(f"{given!r} is not a mapping of keys to values; {_hint(given)}")
        return given

    @classmethod
    def _spread(cls, given: dict[Any, Any]) -> dict[Any, Any]:
        """Hand what is for both ways to each, the way back through the contact plan, and fill up from the preset."""
        data = super()._spread(given)
        plan = given.get("contact_plan")
        if isinstance(plan, dict):
            data["down"] = data["down"] | {"contact_plan": {**plan, "reverse": not plan.get("reverse", False)}}
        preset = given.get("preset")
        if isinstance(preset, str) and preset in PRESETS:
            for way in cls.keys_for_each:
                own = data.get(way, {})
                if isinstance(own, LinkDirection):
                    own = own.model_dump()
                if isinstance(own, dict):
                    data[way] = over_preset(preset, own, LinkDirection.bare_names())
        return data


def _hint(word: str) -> str:
    """Return how to write a value that was given in place of a link's mapping."""
    import difflib  # 10 ms that a good file need not wait for

    if number_in(word) is not None:
        return f"write 'link: {{delay: {word}}}' for a one-way delay"
    near = [word] if word in PRESETS else [name for name in PRESETS if name.startswith(word)]
    near = near or difflib.get_close_matches(word, PRESETS, n=1, cutoff=0.5)
    if near:
        return "write " + " or ".join(f"'link: {{preset: {name}}}'" for name in near)
    return f"for a preset write 'link: {{preset: {'|'.join(PRESETS)}}}'"
