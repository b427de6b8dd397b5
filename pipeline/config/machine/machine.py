"""The machine: rails, links, triangle, clearances, limits and masses."""

from typing import Self

import numpy as np
from pydantic import Field, model_validator

from pipeline.config.choices import TriangleBranch
from pipeline.config.machine.actuators import ActuatorsConfig
from pipeline.config.machine.bodies import Bodies, LinkBodiesConfig, require_names
from pipeline.config.machine.limits import LimitsConfig
from pipeline.config.machine.links import ClearanceConfig, LinksConfig, RailConfig
from pipeline.config.machine.masses import DynamicsConfig
from pipeline.config.section import PositiveLength, Section, wrong


class MachineConfig(Section):
    """The machine: everything its kinematics, clearances and limits depend on."""

    rails: tuple[RailConfig, RailConfig, RailConfig] = Field(
        description="of arms 1, 2, 3, along X or nearly so: where they are, and the travel of their carts"
    )
    links: LinksConfig
    triangle_branch: TriangleBranch = Field(
        TriangleBranch.NEGATIVE, description="sign of y_platform . (w x u_3c) that the assembled machine keeps"
    )
    characteristic_length_m: PositiveLength = Field(
        1.0, description="moments are divided by it for kappa: about the size of the machine"
    )
    clearance: ClearanceConfig
    bodies: Bodies = Field(
        (),
        description="convex bodies that nothing may touch, such as "
        "{name: nose, attached_to: platform, capsule: {from_m: [0, 0.02, 0], to_m: [0, 0.07, 0], radius_m: 0.02}}",
        exclude_if=lambda value: not value,
    )
    link_bodies: LinkBodiesConfig | None = Field(
        None,
        description="the links as rods and tubes; null: axes, clearance.link_link_m apart",
        exclude_if=lambda value: value is None,
    )
    limits: LimitsConfig
    dynamics: DynamicsConfig | None = Field(
        None, description="masses, for forces and their limits; null: no forces, and no limits of forces either"
    )
    actuators: ActuatorsConfig = Field(
        default_factory=lambda: ActuatorsConfig(),
        description="what the controller's positions q are in this geometry: middle of the range + zero_m + scale (q - "
        "middle); files for controllers are written with it, planning is not concerned",
    )

    def holding(self) -> dict[str, object]:
        """Give the keys that holding forces and their limits follow from; none if no forces are limited."""
        if self.dynamics is None or not self.limits.of_forces():
            return {}
        return {
            "limits": self.limits.holding(),
            "dynamics": self.dynamics.model_dump(mode="json", exclude={"platform": {"inertia_kgm2"}}),
        }

    @model_validator(mode="after")
    def _forces_can_be_computed(self) -> Self:
        if self.dynamics is None and (limited := self.limits.of_forces()):
            raise wrong(
                "dynamics",
                f"is missing, and without masses there are no forces to hold against machine.limits."
                f"{limited[0]}; give it, or leave out {' and '.join(f'machine.limits.{key}' for key in limited)}",
            )
        return self

    @model_validator(mode="after")
    def _links_have_one_distance(self) -> Self:
        axes = self.clearance.link_link_m
        if self.link_bodies is None and axes is None:
            raise wrong("clearance.link_link_m", "is missing; allowed is a number from 0 to 1, or machine.link_bodies")
        if self.link_bodies is not None and axes is not None:
            raise wrong(
                "clearance.link_link_m",
                f"is {axes:g}, between axes, where machine.link_bodies gives the links surfaces: leave it out; "
                "machine.clearance.bodies_m is kept between these",
            )
        return self

    @model_validator(mode="after")
    def _beams_are_along_rails(self) -> Self:
        beams = [body.name for body in self.bodies if body.beam is not None]
        for k, rail in enumerate(self.rails):
            if rail.slopes != (0.0, 0.0) and beams:
                raise wrong(
                    f"rails[{k}].slopes",
                    f"are not 0, but {beams[0]} is a beam, endless along X: make beams boxes or hulls of the frame, or "
                    "leave out the slopes",
                )
        return self

    @model_validator(mode="after")
    def _bodies_fit(self) -> Self:
        require_names("bodies", self.bodies)
        if not self.bodies and self.link_bodies is None:
            return self
        lengths = {"l1": self.links.l1.length_m, "l2a": self.links.l2a.length_m, "l3a": self.links.l3a.length_m}
        lengths |= {"l2b": self.links.l2b.stroke_m[0], "l3b": self.links.l3b.stroke_m[0]}
        if self.links.l3c.length_m is not None:
            lengths["l3c"] = self.links.l3c.length_m
        trim = self.clearance.joint_trim_m
        for name, length in lengths.items():
            if trim.platform + trim.cart >= length:
                raise wrong("clearance.joint_trim_m", f"leaves nothing of link {name}, {length:g} m long at least")
        for name in ("l2b", "l3b"):
            tube = None if self.link_bodies is None else getattr(self.link_bodies, name).tube_length_m
            if tube is not None and not trim.cart < tube <= lengths[name]:
                raise wrong(
                    f"link_bodies.{name}.tube_length_m",
                    f"is {tube:g}; allowed is more than clearance.joint_trim_m.cart ({trim.cart:g}), at most the "
                    f"least stroke ({lengths[name]:g})",
                )
        self._require_short_bodies(lengths)
        return self

    def _require_short_bodies(self, lengths: dict[str, float]) -> None:
        """Refuse a body on a link that is longer than the link ever is."""
        for k, body in enumerate(self.bodies):
            end, capsule = body.attached_to.link_end, body.capsule
            if end is None or capsule is None or end[0] not in lengths:
                continue
            far = max(abs(capsule.from_m[2]), abs(capsule.to_m[2]))
            if far > lengths[end[0]]:
                raise wrong(
                    f"bodies[{k}].capsule",
                    f"reaches {far:g} m along link {end[0]}, which is {lengths[end[0]]:g} m long at least "
                    f'(of "{body.name}")',
                )

    @model_validator(mode="after")
    def _triangle_closes(self) -> Self:
        first, third = self.links.l3a, self.links.l3c
        side = np.subtract(third.platform_point_m, first.platform_point_m)
        base = np.linalg.norm(np.subtract(third.cart_offset_m, first.cart_offset_m))
        if not side[[0, 2]].any():
            raise wrong("links.l3c.platform_point_m", "must not lie on the line through 3a's along y: nothing holds ry")
        if third.length_m is None and base > 0.0:
            raise wrong(
                "links.l3c.length_m", "is missing; it can be left out only when 3a and 3c have one cart_offset_m"
            )
        if third.length_m is not None and abs(third.length_m - first.length_m) > np.linalg.norm(side) + base:
            raise wrong(
                "links.l3c.length_m",
                f"is {third.length_m:g}, which cannot close the triangle with link 3a ({first.length_m:g} m) and "
                f"the platform side ({np.linalg.norm(side):g} m)",
            )
        return self
