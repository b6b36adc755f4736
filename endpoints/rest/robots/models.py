"""Route of the robot models that robot files may name."""

from fastapi import APIRouter
from pydantic import BaseModel, Field

from endpoints.rest.dependencies import AnyCaller
from endpoints.rest.openapi import KNOWN
from ppaas.robot_model.known_models import model_names, robot_model

router = APIRouter(prefix="/models", tags=["models"])


class ModelAnswer(BaseModel):
    """Robot model."""

    name: str
    robot_radius: float = Field(description="Radius of its round footprint [m]")
    max_vel_x: float = Field(description="Maximum linear velocity [m/s]")
    max_vel_theta: float = Field(description="Maximum angular velocity [rad/s]")


class ModelPage(BaseModel):
    """All models, on a single page."""

    items: list[ModelAnswer]
    next: None = None


@router.get("", response_model=ModelPage, responses=KNOWN)
async def list_models(_user: AnyCaller) -> ModelPage:
    """List the robot models that robot files may name."""
    return ModelPage(items=[_answer(name) for name in model_names()])


def _answer(name: str) -> ModelAnswer:
    model = robot_model(name)
    return ModelAnswer(
        name=model.name,
        robot_radius=model.robot_radius,
        max_vel_x=model.limits.max_vel_x,
        max_vel_theta=model.limits.max_vel_theta,
    )
