"""A Geometry Nodes group that draws the principal directions from the attributes on a mesh.

Principal directions are lines: they have no front, so that the arrows have two heads.
"""

from __future__ import annotations

from typing import Any

import bpy

from ...mesh.attributes import RESULTS
from ..transaction import Transaction

GROUP_TAG = "umbilics_arrows"
# Another layout of the nodes is another group; files keep the one they were made with.
VERSION = 1
# Names of the curvatures, the attribute of the direction, and the colour.
_DIRECTIONS = (
    ("k1", "umbilics_d1", (0.80, 0.10, 0.05, 1.0)),
    ("k2", "umbilics_d2", (0.05, 0.20, 0.80, 1.0)),
)
# An arrow of length 1: radius and share of the shaft, radius of a head. Eight sides are enough.
_SHAFT, _SHAFT_LENGTH, _HEAD, _SIDES = 0.025, 0.7, 0.08, 8


def arrow_group(transaction: Transaction) -> bpy.types.NodeTree:
    """The group in this file, made if there is none."""
    for group in bpy.data.node_groups:
        if group.get(GROUP_TAG) == VERSION and group.library is None:
            return group
    group = transaction.made(bpy.data.node_groups.new("Umbilics Arrows", "GeometryNodeTree"))
    group[GROUP_TAG] = VERSION
    group.is_modifier = True
    _Builder(group, transaction).build()
    return group


class _Builder:
    """Makes and links the nodes of the group."""

    def __init__(self, group: bpy.types.NodeTree, transaction: Transaction) -> None:
        self._group, self._transaction = group, transaction

    def build(self) -> None:
        self._interface()
        given = self._node("NodeGroupInput")
        points = given.outputs["Geometry"]
        length = self._math("MULTIPLY", given.outputs["Length"], self._mean_edge(points))
        chosen = self._every(given.outputs["Every"])
        arrow = self._arrow()
        joined = self._node("GeometryNodeJoinGeometry")
        self._link(self._shown(given.outputs["Mesh"], points), joined.inputs[0])
        for name, attribute, colour in _DIRECTIONS:
            coloured = self._node("GeometryNodeSetMaterial")
            self._link(arrow, coloured.inputs["Geometry"])
            coloured.inputs["Material"].default_value = _material(name, colour, self._transaction)
            shape = coloured.outputs[0]
            arrows = self._instances(points, chosen, attribute, shape, length)
            self._link(self._shown(given.outputs[name], arrows), joined.inputs[0])
        self._link(joined.outputs[0], self._node("NodeGroupOutput").inputs["Geometry"])

    def _interface(self) -> None:
        sockets = self._group.interface
        sockets.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        sockets.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        length = sockets.new_socket("Length", in_out="INPUT", socket_type="NodeSocketFloat")
        length.description = "Length of the arrows, in mean edges of the mesh"
        length.default_value, length.min_value, length.max_value = 0.8, 0.0, 1000.0
        every = sockets.new_socket("Every", in_out="INPUT", socket_type="NodeSocketInt")
        every.description = "Only every so many vertices have arrows"
        every.default_value, every.min_value, every.max_value = 1, 1, 1_000_000
        texts = {
            "k1": "Show the direction of the larger principal curvature",
            "k2": "Show the direction of the smaller principal curvature",
            "Mesh": "Show the mesh as well",
        }
        for name, text in texts.items():
            shown = sockets.new_socket(name, in_out="INPUT", socket_type="NodeSocketBool")
            shown.description = text
            shown.default_value = True

    def _node(self, kind: str, **values: Any) -> bpy.types.Node:
        node = self._group.nodes.new(kind)
        # In the order of the work, from left to right.
        node.location = (220.0 * len(self._group.nodes), 0.0)
        for name, value in values.items():
            setattr(node, name, value)
        return node

    def _link(self, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
        self._group.links.new(source, target)

    def _math(
        self, operation: str, first: bpy.types.NodeSocket, second: bpy.types.NodeSocket | float
    ) -> bpy.types.NodeSocket:
        node = self._node("ShaderNodeMath", operation=operation)
        self._link(first, node.inputs[0])
        if isinstance(second, bpy.types.NodeSocket):
            self._link(second, node.inputs[1])
        else:
            node.inputs[1].default_value = second
        return node.outputs[0]

    def _mean_edge(self, mesh: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        ends = self._node("GeometryNodeInputMeshEdgeVertices")
        distance = self._node("ShaderNodeVectorMath", operation="DISTANCE")
        self._link(ends.outputs["Position 1"], distance.inputs[0])
        self._link(ends.outputs["Position 2"], distance.inputs[1])
        statistic = self._node("GeometryNodeAttributeStatistic", domain="EDGE")
        self._link(mesh, statistic.inputs["Geometry"])
        self._link(distance.outputs["Value"], _usable(statistic.inputs, "Attribute"))
        return _usable(statistic.outputs, "Mean")

    def _every(self, count: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        index = self._node("GeometryNodeInputIndex")
        rest = self._math("MODULO", index.outputs[0], count)
        return self._math("LESS_THAN", rest, 0.5)

    def _arrow(self) -> bpy.types.NodeSocket:
        """An arrow of length 1 along z, with a head at both ends."""
        joined = self._node("GeometryNodeJoinGeometry")
        shaft = self._node("GeometryNodeMeshCylinder")
        self._fill(shaft, Vertices=_SIDES, Radius=_SHAFT, Depth=_SHAFT_LENGTH)
        self._link(shaft.outputs["Mesh"], joined.inputs[0])
        head = 0.5 * (1.0 - _SHAFT_LENGTH)
        for end in (1.0, -1.0):
            cone = self._node("GeometryNodeMeshCone")
            radii = (0.0, _HEAD) if end > 0 else (_HEAD, 0.0)
            self._fill(
                cone,
                Vertices=_SIDES,
                **{"Radius Top": radii[0], "Radius Bottom": radii[1], "Depth": head},
            )
            moved = self._node("GeometryNodeTransform")
            self._link(cone.outputs["Mesh"], moved.inputs["Geometry"])
            # A cone of Geometry Nodes stands on the plane z = 0.
            foot = 0.5 * _SHAFT_LENGTH if end > 0 else -0.5
            moved.inputs["Translation"].default_value = (0.0, 0.0, foot)
            self._link(moved.outputs[0], joined.inputs[0])
        return joined.outputs[0]

    def _fill(self, node: bpy.types.Node, **values: Any) -> None:
        for name, value in values.items():
            node.inputs[name].default_value = value

    def _instances(
        self,
        points: bpy.types.NodeSocket,
        chosen: bpy.types.NodeSocket,
        attribute: str,
        shape: bpy.types.NodeSocket,
        length: bpy.types.NodeSocket,
    ) -> bpy.types.NodeSocket:
        """The shape along a direction attribute at the chosen points that have it."""
        named = self._node("GeometryNodeInputNamedAttribute", data_type=RESULTS[attribute][1])
        named.inputs["Name"].default_value = attribute
        direction = _usable(named.outputs, "Attribute")
        aligned = self._node("FunctionNodeAlignRotationToVector", axis="Z")
        self._link(direction, aligned.inputs["Vector"])
        size = self._node("ShaderNodeVectorMath", operation="LENGTH")
        self._link(direction, size.inputs[0])
        # The direction is zero where no curvature could be found, and where it is missing.
        known = self._math("GREATER_THAN", size.outputs["Value"], 0.5)
        placed = self._node("GeometryNodeInstanceOnPoints")
        self._link(points, placed.inputs["Points"])
        self._link(self._math("MULTIPLY", chosen, known), placed.inputs["Selection"])
        self._link(shape, placed.inputs["Instance"])
        self._link(aligned.outputs["Rotation"], placed.inputs["Rotation"])
        self._link(length, placed.inputs["Scale"])
        return placed.outputs["Instances"]

    def _shown(
        self, shown: bpy.types.NodeSocket, geometry: bpy.types.NodeSocket
    ) -> bpy.types.NodeSocket:
        node = self._node("GeometryNodeSwitch", input_type="GEOMETRY")
        self._link(shown, node.inputs["Switch"])
        self._link(geometry, _usable(node.inputs, "True"))
        return _usable(node.outputs, "Output")


def _usable(sockets: bpy.types.NodeInputs, name: str) -> bpy.types.NodeSocket:
    """The socket of that name for the type chosen: some Blenders hide one for every type."""
    return next(socket for socket in sockets if socket.name == name and socket.enabled)


def _material(
    name: str, colour: tuple[float, float, float, float], transaction: Transaction
) -> bpy.types.Material:
    for material in bpy.data.materials:
        if material.get(GROUP_TAG) == name and material.library is None:
            return material
    material = transaction.made(bpy.data.materials.new(f"Umbilics {name}"))
    material[GROUP_TAG] = name
    material.diffuse_color = colour
    if material.node_tree is None:
        material.use_nodes = True  # from Blender 5 on it always does
    shader = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = colour
    return material
