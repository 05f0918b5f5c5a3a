"""The node types there are, from their declarations."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, List, Mapping

from . import _tactor


@dataclass(frozen=True)
class Port:
    """An input or output of a node type."""

    name: str
    message: str  #: the name of its message type
    doc: str
    required: bool = False


@dataclass(frozen=True)
class Parameter:
    """A parameter of a node type."""

    name: str
    kind: str  #: `real`, `integer`, `choice`, ...
    unit: str  #: SI; "1" for plain numbers
    default: Any  #: in that unit; None where it must be given, or has no plain value
    required: bool
    min: float
    max: float
    choices: List[str]
    tunable: bool  #: `Session.set` may set it
    doc: str


@dataclass(frozen=True)
class NodeType:
    """The declaration of a node type; `print(tactor.nodes()["prediction.ar"])` tells all of it."""

    type: str
    summary: str
    details: str
    role: str
    inputs: Dict[str, Port]
    outputs: Dict[str, Port]
    params: Dict[str, Parameter]
    metrics: Dict[str, str]  #: one line on each

    def __str__(self) -> str:
        return self.__doc__ or ""

    def __repr__(self) -> str:
        return f"<tactor.NodeType {self.type}: {self.summary}>"


def nodes() -> Dict[str, NodeType]:
    """The declarations of all node types, by type."""
    return {said["type"]: _node_type(said) for said in _tactor.declarations()}


def _node_type(said: Mapping[str, Any]) -> NodeType:
    inputs = {one["name"]: Port(**one) for one in said["inputs"]}
    outputs = {one["name"]: Port(**one) for one in said["outputs"]}
    params = {one["name"]: Parameter(**one) for one in said["params"]}
    metrics = {one["name"]: one["doc"] for one in said["metrics"]}
    lines = [f"{said['type']}: {said['summary']}", ""]
    if said["details"]:
        lines += [said["details"], ""]
    for title, ports in (("Inputs", inputs), ("Outputs", outputs)):
        if ports:
            lines += [f"{title}:"] + [f"    {port.name} ({port.message}): {port.doc}" for port in ports.values()] + [""]
    if params:
        lines += ["Parameters:"]
        for one in params.values():
            unit = "" if one.unit == "1" else f" [{one.unit}]"
            default = "required" if one.required else f"default {one.default}"
            lines.append(f"    {one.name}{unit} ({default}): {one.doc}")
    made = NodeType(said["type"], said["summary"], said["details"], said["role"], inputs, outputs, params, metrics)
    object.__setattr__(made, "__doc__", "\n".join(lines).rstrip())
    return made
