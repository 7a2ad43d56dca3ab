"""What missions, recipes and suites share: names, places, the bounds of times and lengths, acceptance and start."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Annotated, Any, Final, Literal, TypeAlias, cast, get_args

from pydantic import AfterValidator, Field, Strict, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity

DAY_S: Final = 86_400.0
FURTHEST_M: Final = 10_000.0  # of a coordinate


def line_of_text(text: str) -> str:
    """Return a text that fits in a line.

    Raises:
        ValueError: it has line breaks or other control characters.
    """
    if not text.isprintable():
        raise ValueError(f"{text!r} is not one line of text without control characters")
    return text


def file_beside(name: str) -> str:
    """Return the name of a file that a log can carry: one beside the mission file or below its folder.

    Raises:
        ValueError: it leads elsewhere.
    """
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or "\\" in name or str(path) != name:
        raise ValueError(f"{name!r} is not a file beside the mission or below its folder: write 'plan.ionrc' or 'a/b'")
    return name


def error_at(problem: str, loc: tuple[str | int, ...], value: object) -> InitErrorDetails:
    """Return a problem with a value somewhere below what is being checked, for a ValidationError."""
    kind = PydanticCustomError("mission", "{problem}", {"problem": problem})
    return InitErrorDetails(type=kind, loc=loc, input=value)


def raise_errors(title: str, errors: list[InitErrorDetails]) -> None:
    """Raise a ValidationError of some problems, if there are any."""
    if errors:
        raise ValidationError.from_exception_data(title, errors)


Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=60), AfterValidator(line_of_text)]
Coordinate: TypeAlias = Annotated[float, Quantity("m", ge=-FURTHEST_M, le=FURTHEST_M)]
FileName: TypeAlias = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(file_beside)]
RobotName: TypeAlias = Annotated[str, Field(min_length=1, max_length=1000), AfterValidator(line_of_text)]
Position: TypeAlias = tuple[Coordinate, Coordinate]
AcceptanceShape: TypeAlias = Literal["box", "radius"]
ACCEPTANCE_SHAPES: Final[tuple[str, ...]] = get_args(AcceptanceShape)
Tolerance: TypeAlias = Annotated[float, Quantity("m", gt=0, le=100)]
Timeout: TypeAlias = Annotated[float, Quantity("s", gt=0, le=DAY_S)]
Hold: TypeAlias = Annotated[float, Quantity("s", ge=0, le=DAY_S)]


def bounds_of(field: Any) -> Quantity:
    """Return the bounds of a number, such as `Tolerance`."""
    return next(part for part in get_args(field) if isinstance(part, Quantity))


class Acceptance(FileModel):
    """The region around a waypoint that counts as having reached it."""

    shape: AcceptanceShape = Field(
        "box", description="box (the paper's): |dx| and |dy| below the size; radius: the distance below it"
    )
    size_m: Tolerance = Field(0.5, description="half the box's side, or the radius")

    @classmethod
    def of(cls, shape: str, size_m: float) -> Acceptance:
        """Return the region of a command that has been checked on its arrival: nothing is checked again."""
        return cls.model_construct(shape=cast("AcceptanceShape", shape), size_m=size_m)

    def __str__(self) -> str:
        """Return it for people: "box 0.5 m"."""
        return f"{self.shape} {self.size_m:g} m"


class Start(FileModel):
    """Pose of the robot at the start, and the spread of its state around the nominal pose."""

    position_m: Position = Field((0.0, 0.0), description="x and y in the world frame")
    heading_deg: Annotated[float, Quantity("deg", ge=-360, le=360)] = Field(0.0, description="0 is along x, 90 along y")
    random_heading: Annotated[bool, Strict()] = Field(False, description="draw the heading, in place of `heading`")
    joint_spread_rad: Annotated[float, Quantity("rad", ge=0, le=1)] = Field(
        0.1, description="largest offset of the joint angles from the nominal pose"
    )
    speed_spread: Annotated[float, Strict(), Field(ge=0, le=5)] = Field(
        0.1, description="largest velocities, in m/s and rad/s"
    )
