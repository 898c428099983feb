"""Builds the parts of a body from what a file gives: meshes and primitives, placed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.findings.codes import Finding
from gcodesim.machine import shapes
from gcodesim.machine.files import inside
from gcodesim.machine.kinematics import rotation
from gcodesim.machine.mesh import read_mesh
from gcodesim.machine.mesh_units import MeshRead
from gcodesim.machine.model import Joint, Part
from gcodesim.machine.schema import BodySpec, MeshSpec, PlacementSpec, ShapeSpec
from gcodesim.machine.tree import unit_vector
from gcodesim.machine.yaml_lines import YamlFile

Array = NDArray[np.float64]


def longest_travel(joints: Sequence[Joint]) -> float:
    """Longest finite travel of the linear joints [mm], 0 when there is none."""
    travels = [joint.upper - joint.lower for joint in joints if not joint.rotary]
    return max((t for t in travels if math.isfinite(t)), default=0.0)


@dataclass
class PartReader:
    """Reads the shapes of one file.

    Attributes:
        source: the file; mesh paths are relative to its folder.
        unit: unit of its mesh files that state none.
        allow_outside: meshes may lie outside that folder.
        findings: what the meshes had to say so far.
        read: the mesh files whose unit nobody stated.
    """

    source: YamlFile
    unit: str
    allow_outside: bool = False
    findings: list[Finding] = field(default_factory=list)
    read: list[MeshRead] = field(default_factory=list)

    def parts(self, body: BodySpec, name: str, role: str, *key: str | int) -> tuple[Part, ...]:
        """Parts of a body at a key of the file; a single shape is named as its body."""
        if body.parts is not None:
            return tuple(
                self.part(shape, shape.name, role, *key, "parts", i)
                for i, shape in enumerate(body.parts)
            )
        return (self.part(body, name, role, *key),) if body.kind else ()

    def part(self, shape: ShapeSpec, name: str, role: str, *key: str | int) -> Part:
        """One shape, placed."""
        if shape.mesh is not None:
            return self.mesh(shape, name, role, *key)
        part = self._primitive(shape, name, role, *key)
        if shape.placement is None:
            return part
        return replace(part, triangles=_placed(part.triangles, shape.placement))

    def mesh(self, shape: MeshSpec, name: str, role: str, *key: str | int) -> Part:
        """A mesh file, placed, with its findings noted."""
        assert shape.mesh is not None
        path, shell = self._mesh_path(shape.mesh, *key, "mesh"), bool(shape.shell)
        mesh = read_mesh(path, shape.units or self.unit, shell=shell)
        self.findings += [f for f in mesh.findings if f not in self.findings]
        triangles = mesh.triangles
        if isinstance(shape, ShapeSpec) and shape.placement is not None:
            triangles = _placed(triangles, shape.placement)
        part = Part(name, triangles, mesh.closed, role, shape.mesh, shell)
        if shape.units is None:
            self.read.append(MeshRead(part, path, self.unit))
        return part

    def _mesh_path(self, file: str, *key: str | int) -> Path:
        path = inside(self.source, file, self.allow_outside, *key)
        if not path.is_file():
            text = f"mesh file {path} does not exist; its path is relative to this file"
            raise self.source.error(text, *key)
        return path

    def _primitive(self, shape: ShapeSpec, name: str, role: str, *key: str | int) -> Part:
        kind = shape.kind
        try:
            triangles, radius = self._triangles(shape, *key, kind)
        except ValueError as error:
            raise self.source.error(str(error), *key, kind) from None
        source = kind
        if radius:
            source += f", {shapes.SIDES} sides, at most {shapes.excess(radius):.3g} mm too large"
        return Part(name, triangles, True, role, source)

    def _triangles(self, shape: ShapeSpec, *key: str | int) -> tuple[Array, float]:
        """Triangles of a primitive and its largest radius [mm], 0 for a flat one."""
        if shape.box is not None:
            return shapes.box(shape.box.size, shape.box.center), 0.0
        if shape.extrude is not None:
            return shapes.extrude(shape.extrude.polygon, shape.extrude.height), 0.0
        if shape.revolve is not None:
            return shapes.revolve(shape.revolve), max(r for r, _ in shape.revolve)
        if shape.cylinder is not None:
            round_ = shape.cylinder
            top = round_.radius
        else:
            assert shape.cone is not None  # the last kind left
            round_, top = shape.cone, shape.cone.top_radius
        axis = unit_vector(round_.axis, self.source, *key, "axis")
        triangles = shapes.cone(round_.radius, top, round_.height, round_.center, axis)
        return triangles, max(round_.radius, top)


def _placed(triangles: Array, placement: PlacementSpec) -> Array:
    """Turned about fixed X, then Y, then Z, then shifted."""
    about_x, about_y, about_z = (
        rotation(axis, angle) for axis, angle in zip(np.eye(3), placement.rotate, strict=True)
    )
    return shapes.place(triangles, about_z @ about_y @ about_x, placement.translate)
