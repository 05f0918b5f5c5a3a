"""Messages as numpy structured arrays that know their units, and what their fields mean."""
from __future__ import annotations

import json
import textwrap
from dataclasses import dataclass, field as member
from typing import Any, Dict, Iterator, List, Optional, Tuple

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class Field:
    """A field of a message, or of a record in it."""

    name: str
    unit: str  #: SI; "1" for plain numbers; "ns" for times
    frame: str  #: that its vectors are expressed in; empty: none
    kind: str  #: `f64`, `i32`, ... or `record`
    shape: Tuple[int, ...]
    changes_size: bool  #: an array of as many elements as each message has
    values: Dict[str, int]  #: of an enumeration: its names
    record: Optional[MessageType]
    doc: str = member(default="", compare=False)  #: what it means; empty in a recording
    value_docs: Dict[str, str] = member(default_factory=dict, compare=False)  #: of names that do not say it


@dataclass(frozen=True)
class MessageType:
    """What a message holds: its fields with units, frames and meaning.

    `help(session.feed("hand").type)` and `print` show them all. Two types that differ only in `doc` are equal; a
    recording keeps no `doc`.
    """

    name: str
    frame: str
    fields: Tuple[Field, ...]
    description: str = member(compare=False)  #: JSON, as `tactor schema --messages` prints it
    doc: str = member(default="", compare=False)  #: what it is, and what its stamp means

    def __post_init__(self) -> None:
        object.__setattr__(self, "__doc__", _help_of(self))

    def __str__(self) -> str:
        return self.__doc__ or ""

    def __repr__(self) -> str:
        return f"<tactor.MessageType {self.name}>"

    @classmethod
    def from_json(cls, description: str) -> MessageType:
        made = _type_of(json.loads(description), "")
        return cls(made.name, made.frame, made.fields, description, made.doc)

    def field(self, name: str) -> Optional[Field]:
        """The field of that name, or None."""
        return next((field for field in self.fields if field.name == name), None)

    def leaves(self) -> Iterator[Tuple[str, Field]]:
        """Each field of numbers with its path, such as `X_WT.p`."""
        for field in self.fields:
            yield field.name, field
            if field.record is not None:
                for path, leaf in field.record.leaves():
                    yield f"{field.name}.{path}", leaf

    @property
    def units(self) -> Dict[str, str]:
        """The SI unit of each field of numbers, by its path."""
        return {path: field.unit for path, field in self.leaves() if field.record is None}

    @property
    def frames(self) -> Dict[str, str]:
        """The frame of each field that has one, by its path."""
        return {path: field.frame for path, field in self.leaves() if field.frame and field.record is None}

    @property
    def enumerations(self) -> Dict[str, Dict[str, int]]:
        """The names of the values of each enumeration, by its path."""
        return {path: field.values for path, field in self.leaves() if field.values}


def _type_of(said: Dict[str, Any], outer: str) -> MessageType:
    frame = said.get("frame") or outer
    fields = tuple(_field_of(field, frame) for field in said["fields"])
    name = said.get("name") or said.get("record") or ""
    return MessageType(name, frame, fields, json.dumps(said), said.get("doc", ""))


def _field_of(said: Dict[str, Any], outer: str) -> Field:
    frame = said.get("frame") or outer
    record = None
    if "fields" in said:
        record = _type_of({"name": said["record"], "frame": frame, "fields": said["fields"]}, frame)
    return Field(said["name"], said.get("unit", "1"), frame, said["kind"], tuple(said.get("shape", ())),
                 bool(said.get("changes_size", False)), dict(said.get("enumerators", {})), record,
                 said.get("doc", ""), dict(said.get("docs", {})))


def _help_of(type: MessageType) -> str:
    """The type and all of its fields as text for people."""
    lines: List[str] = [*textwrap.wrap(f"{type.name}: {type.doc}" if type.doc else type.name, 116), "", "Fields:"]
    for path, field in type.leaves():
        kind = field.record.name if field.record is not None else field.kind
        sizes = [str(n) for n in field.shape]
        parts = [f"{kind} [{' x '.join(sizes)}]" if sizes else kind]
        if field.changes_size:
            parts.append("any number")
        if field.record is None and field.unit != "1":
            parts.append(field.unit)
        if field.record is None and field.frame and sizes:
            parts.append(f"in {field.frame}")
        lines.append(f"    {path} ({', '.join(parts)})")
        lines += [f"        {line}" for line in textwrap.wrap(field.doc, 108)]
        for name, value in field.values.items():
            said = f"{name} = {value}" + (f": {field.value_docs[name]}" if name in field.value_docs else "")
            lines += textwrap.wrap(said, 108, initial_indent=" " * 12, subsequent_indent=" " * 16)
    return "\n".join(lines)


class Messages(np.ndarray[Any, np.dtype[Any]]):
    """A structured array of messages, one a row: `valid_ns`, `produced_ns` and `sequence`, then the message's fields.

    An ordinary numpy array, with `type`, `units` and `attrs` beside. Slices, masks and records in it (`m["X_WT"]`) keep
    them. A field of numbers (`m["force"]`) is a plain array: what numpy makes of it may have another unit.
    """

    type: Optional[MessageType]
    attrs: Dict[str, Any]

    def __new__(cls, array: npt.NDArray[Any], type: Optional[MessageType] = None,
                attrs: Optional[Dict[str, Any]] = None) -> Messages:
        made = np.asarray(array).view(cls)
        made.type = type
        made.attrs = dict(attrs or {})
        return made

    def __array_finalize__(self, source: Optional[npt.NDArray[Any]]) -> None:
        self.type = getattr(source, "type", None)
        self.attrs = getattr(source, "attrs", {})

    @property
    def units(self) -> Dict[str, str]:
        """The SI unit of each field of numbers, by its path: `force`, `X_WT.p`; "1" for plain numbers."""
        if self.type is None:
            raise ValueError("the units of this array are lost, because numpy made it out of others; "
                             "take them from one of those, or make it by Messages(array, type)")
        names = self.dtype.names or ()
        stamps = {"valid_ns": "ns", "produced_ns": "ns", "sequence": "1"}
        units = {name: unit for name, unit in stamps.items() if name in names and self.type.field(name) is None}
        return units | {path: unit for path, unit in self.type.units.items() if path.split(".")[0] in names}

    @property
    def time(self) -> npt.NDArray[np.float64]:
        """The times that the messages hold for, in s since the start of the run."""
        return np.asarray(self["valid_ns"], np.float64) * 1e-9

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        if not isinstance(found, Messages):
            return found
        if found.dtype.names is None:
            return found.view(np.ndarray)
        if isinstance(key, str) and self.type is not None:
            field = self.type.field(key)
            found.type = field.record if field is not None else None
        return found

    def __reduce__(self) -> Any:
        made, arguments, state = super().__reduce__()  # type: ignore[misc]
        return made, arguments, (state, self.type, self.attrs)

    def __setstate__(self, state: Any) -> None:
        of_array, self.type, self.attrs = state
        super().__setstate__(of_array)


def messages(array: npt.NDArray[Any], type: MessageType, **attrs: Any) -> Messages:
    """An array of the extension with what is known of its type."""
    return Messages(array, type, {"message_type": type.name, "frame": type.frame, "time_unit": "ns", **attrs})


_CURVES: Dict[str, MessageType] = {}


def curve(name: str, unit: str, time: npt.NDArray[np.float64], value: npt.NDArray[np.float64]) -> Messages:
    """A curve over time as a structured array of `time` (s) and `value`."""
    if unit not in _CURVES:
        fields = [{"name": "time", "unit": "s", "kind": "f64"}, {"name": "value", "unit": unit, "kind": "f64"}]
        _CURVES[unit] = MessageType.from_json(json.dumps({"name": "Curve", "fields": fields}))
    made = np.empty(len(time), [("time", np.float64), ("value", np.float64)])
    made["time"], made["value"] = time, value
    return Messages(made, _CURVES[unit], {"name": name})
