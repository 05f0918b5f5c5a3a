"""What a recording holds beside the time, the machine and the program that made it: the same for the same run, to the byte."""
import h5py


def recorded(path):
    """{name: bytes} of all data sets and attributes of a recording, without its provenance."""
    found = {}

    def take(name, thing):
        for key, value in thing.attrs.items():
            found[f"{name}@{key}"] = bytes(value) if isinstance(value, bytes) else str(value)
        if isinstance(thing, h5py.Dataset):
            found[name] = (str(thing.dtype), thing[()].tobytes())
    with h5py.File(path) as file:
        take("/", file)
        file.visititems(take)
        found.pop("/@provenance", None)
    return found
