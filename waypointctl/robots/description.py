"""robot.yaml: the data of a robot that its MJCF does not contain."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import AfterValidator, Field, Strict, ValidationInfo, field_validator

from waypointctl.mission.fields import line_of_text
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity

ROBOT_FILE: Final = "robot.yaml"
_MOST_JOINTS: Final = 128


def _file_name(name: str) -> str:
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or "\\" in name or str(path) != name or not name.isprintable():
        raise ValueError(f"{name!r} is not a file of this folder: write 'robot.xml' or 'mjcf/robot.xml'")
    return name


JointName: TypeAlias = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(line_of_text)]
Joints: TypeAlias = Annotated[tuple[JointName, ...], Field(min_length=1, max_length=_MOST_JOINTS)]
Number: TypeAlias = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Positive: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1e6, allow_inf_nan=False)]
Length: TypeAlias = Annotated[float, Quantity("m", ge=-100, le=100)]
Angle: TypeAlias = Annotated[float, Quantity("deg", ge=-36_000, le=36_000)]
Speed: TypeAlias = Annotated[float, Strict(), Field(ge=-10_000, le=10_000, allow_inf_nan=False)]

_JOINTS_TEXT: Final = "names of the joints of this group; * matches any text"


class TorqueFraction(FileModel):
    """An action is the fraction of a motor's full control: its control range in the MJCF is -full to full."""

    kind: Literal["torque_fraction"]
    joints: Joints = Field(("*",), description=_JOINTS_TEXT)


class PositionTarget(FileModel):
    """An action sets the target of a position servo: offset + scale x action."""

    kind: Literal["position_target"]
    joints: Joints = Field(("*",), description=_JOINTS_TEXT)
    scale_deg: Annotated[float, Quantity("deg", gt=0, le=36_000)] = Field(
        description="change of the target at action 1"
    )
    offset_deg: Angle | None = Field(None, description="target at action 0; the nominal pose unless given")
    limits_deg: tuple[Angle, Angle] | None = Field(None, description="of the target; the joint's range unless given")


class VelocityTarget(FileModel):
    """An action sets the target of a velocity servo: offset + scale x action."""

    kind: Literal["velocity_target"]
    joints: Joints = Field(("*",), description=_JOINTS_TEXT)
    scale_radps: Annotated[float, Strict(), Field(gt=0, le=10_000)] = Field(
        description="change of the target at action 1 [rad/s]"
    )
    offset_radps: Speed = Field(0.0, description="target at action 0 [rad/s]")
    limits_radps: tuple[Speed, Speed] | None = Field(None, description="of the target [rad/s]; none unless given")


ActionGroup: TypeAlias = Annotated[TorqueFraction | PositionTarget | VelocityTarget, Field(discriminator="kind")]


class NominalPose(FileModel):
    """The nominal pose: at the start, at a hold, and as the zero of position targets."""

    height_m: Annotated[float, Quantity("m", gt=0, le=100)] = Field(description="of the base's origin over the ground")
    joints_deg: Annotated[dict[JointName, Number], Field(max_length=_MOST_JOINTS)] = Field(
        default_factory=dict, description="angle of each joint by its name; a joint that is not listed is at 0"
    )


class StanceGains(FileModel):
    """The spring and damper that hold a joint at its nominal angle when no policy drives the robot; of motors alone."""

    stiffness: Positive = Field(1.0, description="fraction of the full control per rad")
    damping: Positive = Field(0.25, description="fraction of the full control per rad/s")


class Termination(FileModel):
    """When the robot has fallen."""

    min_height_m: Length = Field(description="of the base; a lower one has fallen")
    min_up: Annotated[float, Strict(), Field(ge=-1, le=1)] = Field(
        description="vertical part of the base's upward axis: 1 upright, 0 on its side; a smaller one has fallen"
    )


class Camera(FileModel):
    """The robot's camera: it turns with the yaw of the base, and stays level when the base rolls and pitches."""

    position_m: tuple[Length, Length, Length] = Field(
        (0.0, 0.0, 0.3), description="from the base's origin: ahead, to the left, up"
    )
    pitch_deg: Annotated[float, Quantity("deg", ge=-90, le=90)] = Field(
        0.0, description="below 0 the camera points down"
    )


class SymmetryMap(FileModel):
    """A motion of the robot stays possible when it is mirrored, then turned, and its joints change places."""

    mirror: Annotated[bool, Strict()] = Field(False, description="left and right change places: y becomes -y")
    turn_deg: Angle = Field(0.0, description="then turned about the base's z axis, to the left")
    joints: Annotated[dict[JointName, JointName], Field(max_length=_MOST_JOINTS)] = Field(
        description="the joint that each joint maps to; '-name' where its angle changes sign"
    )


class RobotDescription(FileModel):
    """robot.yaml: the data of a robot that its MJCF does not contain."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=80)] = Field(
        description="robot name that a policy's manifest refers to"
    )
    description: Annotated[str, Field(max_length=4000)] = Field("", description="free text for readers")
    mjcf: Annotated[str, Field(min_length=1, max_length=1000), AfterValidator(_file_name)] = Field(
        description="the MJCF, a file of this folder; it has one floating base and the ground"
    )
    substeps: Annotated[int, Strict(), Field(ge=1, le=1000)] = Field(
        description="physics steps in a control period; the MJCF has the time step"
    )
    actions: Annotated[tuple[ActionGroup, ...], Field(min_length=1, max_length=_MOST_JOINTS)] = Field(
        description="what the numbers of an action mean; every actuator belongs to one entry"
    )
    nominal: NominalPose = Field(description="pose of the robot at the start and at a hold")
    stance: StanceGains = StanceGains()
    termination: Termination = Field(description="when the robot has fallen")
    feet: Annotated[tuple[JointName, ...], Field(max_length=_MOST_JOINTS)] = Field(
        (), description="the geoms that are meant to touch the ground"
    )
    camera: Camera = Camera()
    symmetries: Annotated[dict[JointName, SymmetryMap], Field(max_length=16)] = Field(
        default_factory=dict, description="by name; the symmetries of the robot are these and all that they combine to"
    )

    @field_validator("termination")
    @classmethod
    def _stands_at_start(cls, termination: Termination, info: ValidationInfo) -> Termination:
        nominal = info.data.get("nominal")  # absent where it is wrong itself
        if nominal is not None and termination.min_height_m >= nominal.height_m:
            raise ValueError(
                f"min_height {termination.min_height_m:g} m is not below nominal.height, {nominal.height_m:g} m: "
                "the robot would count as fallen at its start"
            )
        return termination
