"""The proof of a path: how sharp, how fine, and what is proven."""

from typing import Self

from pydantic import Field, model_validator

from pipeline.config.choices import Proof
from pipeline.config.section import Section, wrong
from pipeline.config.stages.pose_error import PoseErrorConfig


class CertifyConfig(Section):
    """The proof that a path is free of singularities: boxes along s in ball arithmetic."""

    what: Proof = Field(
        Proof.PATH,
        description="path; tolerances: how wrong the machine may be, too (a minute); following: and how far drives may "
        "be off the path, within limits and on the branch (another minute); nothing",
    )
    precision_bits: int = Field(64, ge=53, le=4_096, description="precision of the ball arithmetic")
    kappa_excess: float = Field(
        0.01,
        gt=0.0,
        le=10.0,
        description="boxes are halved until the bound of kappa exceeds its largest sample by at most this, relatively",
    )
    least_width: float = Field(
        1e-7, gt=1e-12, le=0.1, description="intervals of s narrower than this are not halved: the path is refused"
    )
    tolerance_resolution: float = Field(
        0.02, gt=1e-4, le=1.0, description="how finely tolerances are bisected, relatively"
    )
    monte_carlo_samples: int = Field(
        100,
        ge=0,
        le=100_000,
        description="machines drawn at random to find the calibration error at which the path really fails",
    )
    following_length_m: float = Field(
        0.0,
        ge=0.0,
        le=0.01,
        description="following: errors of the links' lengths that drives may be off beside, as one more claim; 0: none",
    )
    following_coordinate_m: float = Field(
        0.0,
        ge=0.0,
        le=0.01,
        description="following: errors of every coordinate of joints and rails beside which drives may be off",
    )
    pose_error: PoseErrorConfig | None = Field(
        None,
        description="errors of drives and geometry for which the tool's error is proven (pose_error.csv); null: none",
    )

    @model_validator(mode="after")
    def _pose_error_is_proven(self) -> Self:
        if self.pose_error is not None and self.what == Proof.NOTHING:
            raise wrong(
                "pose_error", "needs a proof of the path; allowed is null, or another certify.what than nothing"
            )
        return self
