"""The numbers of a report for the scripts of the page: JSON, with arrays as base64."""

import base64
from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.arrays import FloatArray
from pipeline.machine.bodies.meshes import BodyMesh
from pipeline.machine.geometry import ACTUATORS, LINKS, MODES, TELESCOPES
from pipeline.report import palette
from pipeline.report.data import KappaMaps, Motion, Proof, Report, Scene

OUT_OF_REACH = 0
"""Level of a map that is out of reach."""
_LEVELS = 255


def payload(report: Report) -> dict[str, Any]:
    """Collect what the scripts draw; the rest of the report is in the page itself."""
    return {
        "themes": {"light": asdict(palette.LIGHT), "dark": asdict(palette.DARK)},
        "mapColours": {"scale": palette.MAP, "singular": palette.SINGULAR, "unreachable": palette.OUT_OF_REACH},
        "names": {
            "actuators": ACTUATORS,
            "links": LINKS,
            "telescopes": TELESCOPES.tolist(),
            "modes": MODES,
        },
        "scene": _scene(report.scene),
        "motions": {motion.name: _motion(motion) for motion in report.motions},
        "proof": None if report.proof is None else _proof(report.proof),
    }


def packed(array: npt.NDArray[Any], kind: str = "float32") -> dict[str, Any]:
    """Encode an array of any shape as little-endian bytes of one type, in base64."""
    data = np.ascontiguousarray(array, dtype=np.dtype(kind).newbyteorder("<"))
    return {"kind": kind, "shape": list(data.shape), "base64": base64.b64encode(data.tobytes()).decode()}


def levels(kappa: FloatArray, least: float, largest: float) -> npt.NDArray[np.uint8]:
    """Round kappa to levels 1 to 255, on a logarithmic scale from least to largest; 0 is out of reach."""
    scale = np.log(np.clip(kappa, least, largest) / least) / np.log(largest / least)
    rounded = 1.0 + np.rint(scale * (_LEVELS - 1))
    return np.where(np.isnan(kappa), OUT_OF_REACH, rounded).astype(np.uint8)


def _scene(scene: Scene) -> dict[str, Any]:
    return {
        "rails": scene.rails_m.tolist(),
        "platformBars": scene.platform_bars.tolist(),
        "bodies": [_body(mesh) for mesh in scene.meshes],
        "pairs": [{"name": name, "bodies": pair} for name, pair in zip(scene.pair_names, scene.pairs, strict=True)],
        "clearance": scene.clearance_m,
        "alarmDistance": scene.alarm_m,
        "qLimits": scene.q_limits_m.tolist(),
        # JSON has no infinity: null stands for no limit.
        "qdLimits": [limit if np.isfinite(limit) else None for limit in scene.qd_limits_mps.tolist()],
        "momentUnit": scene.moment_unit,
    }


def _body(mesh: BodyMesh) -> dict[str, Any]:
    return {
        "name": mesh.name,
        "frame": mesh.kind.name.lower(),
        "number": mesh.number,
        "around": mesh.is_around,
        "isLink": mesh.is_link,
        "vertices": packed(mesh.vertices_m),
        "shares": packed(mesh.shares),
        "faces": packed(mesh.faces, "uint16"),
    }


def _motion(motion: Motion) -> dict[str, Any]:
    return {
        "t": packed(motion.t_s),
        "kappa": packed(motion.kappa),
        "pose": packed(motion.pose),
        "q": packed(motion.q_m),
        "qd": packed(motion.qd_mps),
        "modes": packed(motion.modes, "uint8"),
        "feet": packed(motion.feet_m),
        "cartJoints": packed(motion.cart_joints_m),
        "platformJoints": packed(motion.platform_joints_m),
        "nearest": [
            {"of": group.of, "pairs": packed(group.pair, "uint16"), "distances": packed(group.distance_m)}
            for group in motion.nearest
        ],
        "maps": _maps(motion.maps),
    }


def _maps(maps: KappaMaps) -> dict[str, Any]:
    least, largest = kappa_range(maps)
    return {
        "t": packed(maps.t_s),
        "modes": packed(maps.modes, "uint8"),
        "y": packed(maps.y_m),
        "z": packed(maps.z_m),
        "levels": packed(levels(maps.kappa, least, largest), "uint8"),
        "kappaRange": [least, largest],
        "loops": [packed(loop) for loop in maps.loops],
        "titles": maps.titles,
    }


def kappa_range(maps: KappaMaps) -> tuple[float, float]:
    """Compute the least kappa of all maps, and that at which the colour scale ends."""
    known = maps.kappa[np.isfinite(maps.kappa)]
    least = float(known.min()) if known.size else 1.0
    return min(least, 0.5 * maps.colour_limit), maps.colour_limit


def _proof(proof: Proof) -> dict[str, Any]:
    return {
        "edges": packed(proof.edges),
        "bound": [value if np.isfinite(value) else None for value in proof.bound.tolist()],
        "length": packed(proof.length),
        "kappa": packed(proof.kappa),
    }
