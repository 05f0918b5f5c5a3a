"""Recordings, read lazily by h5py."""
from __future__ import annotations

import errno
import os
from types import TracebackType
from typing import Any, Dict, Iterator, Mapping, Optional, Type, Union

import numpy as np
import numpy.typing as npt

from ._errors import InputError
from ._messages import Field, Messages, MessageType
from ._needs import needed


class Stream:
    """A recorded output. `stream[:]`, `stream[-100:]`, `stream[7]` read what they name, and nothing else."""

    def __init__(self, group: Any, name: str) -> None:
        self._group = group
        self._data = group["data"]
        #: `coupling.force`.
        self.name: str = name
        #: What its messages hold.
        self.type: MessageType = MessageType.from_json(_text(group.attrs["description"]))

    @property
    def attrs(self) -> Dict[str, Any]:
        """The attributes of the stream in the file: `message_type`, `frame`, `time_unit`, `description`."""
        return {name: _text(value) for name, value in self._group.attrs.items()}

    @property
    def units(self) -> Dict[str, str]:
        """The SI unit of each field of numbers, by its path."""
        return self.type.units

    def __len__(self) -> int:
        return len(self._data)

    def __getitem__(self, key: Union[int, slice, npt.NDArray[Any]]) -> Any:
        """Messages as one structured array with `.units`; of an integer one message."""
        rows = self._data[key]
        if any(field.changes_size for _, field in self.type.leaves()):
            rows = self._with_arrays(np.asarray(rows))
        if isinstance(rows, np.void) or np.ndim(rows) == 0:
            return rows[()]
        return Messages(rows, self.type, {**self.attrs, "output": self.name})

    def _with_arrays(self, rows: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The rows with the elements of arrays in the place of where these lie in the file."""
        made = np.empty(rows.shape, _with_objects(rows.dtype, self.type.fields))
        _copy(rows, made, self.type.fields, "", self._group["arrays"])
        return made

    def __repr__(self) -> str:
        return f"<tactor.Stream {self.name}: {len(self)} messages of {self.type.name}>"


def _open(h5py: Any, path: str) -> Any:
    try:
        return h5py.File(path, "r")
    except BlockingIOError:
        raise
    except OSError as error:
        # A file system of a cluster may have no locks, and HDF5 opens nothing there unless told to do without.
        if error.errno in (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL):
            return h5py.File(path, "r", locking=False)
        raise


def _is_marked_as_being_written(path: str) -> bool:
    """Whether the superblock says that a writer has the file in the mode that allows readers beside it."""
    flags_at, writing_beside_readers = 11, 0x05
    try:
        with open(path, "rb") as file:
            head = file.read(flags_at + 1)
    except OSError:
        return False
    return len(head) > flags_at and head[flags_at] & writing_beside_readers == writing_beside_readers


class Recording(Mapping[str, Stream]):
    """A recording: streams by name, as a mapping; nothing is read before it is asked for.

        recording = tactor.Recording("out/bunny/recording.h5")
        force = recording["coupling.force"][:]     # a structured array
        force["force"], force.units["force"], force.time

    Raises InputError where the file is none. A context manager, which closes it.
    """

    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        h5py = needed("h5py", "python3-h5py", "to read recordings")
        self.path: str = os.fspath(path)
        try:
            self._file: Any = _open(h5py, self.path)
        except BlockingIOError as error:
            raise InputError(f"{self.path} is being written by another program; read it when that one has ended") from error
        except OSError as error:
            if _is_marked_as_being_written(self.path):
                raise InputError(f"{self.path} is being written by a run, or that run was killed; then `tactor repair` "
                                 "lets it be read") from error
            raise InputError(f"{self.path}: cannot be read as a recording: {error}") from error
        if "tactor_recording" not in self._file.attrs:
            self._file.close()
            raise InputError(f"{self.path}: expected a recording of tactor, found another HDF5 file")

    @property
    def attrs(self) -> Dict[str, Any]:
        """The attributes of the file: `graph` (YAML), `seed`, `tactor_version`, `provenance` (JSON), `complete`."""
        return {name: _text(value) for name, value in self._file.attrs.items()}

    @property
    def graph_yaml(self) -> str:
        """The graph that ran, with every parameter written out."""
        return str(self.attrs["graph"])

    @property
    def units(self) -> Dict[str, Dict[str, str]]:
        """The units of each stream."""
        return {name: stream.units for name, stream in self.items()}

    def __getitem__(self, name: str) -> Stream:
        streams = self._file["streams"]
        if name not in streams:
            raise KeyError(f"{self.path} has no stream '{name}'; it has: {', '.join(streams) or 'none'}")
        return Stream(streams[name], name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._file["streams"])

    def __len__(self) -> int:
        return len(self._file["streams"])

    def close(self) -> None:
        """Closes the file. Arrays that were read stay."""
        self._file.close()

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 traceback: Optional[TracebackType]) -> None:
        self.close()

    def __repr__(self) -> str:
        if not self._file:
            return f"<tactor.Recording {self.path}, closed>"
        return f"<tactor.Recording {self.path}: {', '.join(self)}>"


def _text(value: Any) -> Any:
    return value.decode() if isinstance(value, bytes) else value.item() if isinstance(value, np.generic) else value


def _with_objects(dtype: np.dtype[Any], fields: tuple[Field, ...]) -> np.dtype[Any]:
    """The dtype of rows in a file, in which each field that changes size is an object."""
    by_name = {field.name: field for field in fields}
    made: list[tuple[str, np.dtype[Any]]] = []
    for name in dtype.names or ():
        field, one = by_name.get(name), dtype[name]
        if field is not None and field.changes_size:
            made.append((name, np.dtype(object)))
        elif field is not None and field.record is not None:
            made.append((name, np.dtype((_with_objects(one.base, field.record.fields), one.shape))))
        else:
            made.append((name, one))
    return np.dtype(made)


def _copy(rows: npt.NDArray[Any], made: npt.NDArray[Any], fields: tuple[Field, ...], path: str, arrays: Any) -> None:
    """Copies rows of a file, with each range of a field that changes size as its elements."""
    by_name = {field.name: field for field in fields}
    for name in rows.dtype.names or ():
        field = by_name.get(name)
        if field is not None and field.changes_size:
            elements = arrays[path + name]
            ranges, objects = rows[name].reshape(-1), np.empty(rows[name].size, object)
            for i, one in enumerate(ranges):
                objects[i] = elements[int(one["first"]):int(one["first"]) + int(one["count"])]
            made[name] = objects.reshape(rows[name].shape)
        elif field is not None and field.record is not None:
            _copy(rows[name], made[name], field.record.fields, f"{path}{name}.", arrays)
        else:
            made[name] = rows[name]
