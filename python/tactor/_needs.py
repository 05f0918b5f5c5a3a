"""Packages that only some functions need."""
from __future__ import annotations

import importlib
from typing import Any


def needed(module: str, package: str, what: str) -> Any:
    """The module; raises ImportError, with the Debian package that has it, where it is not installed."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        raise ImportError(f"{module} is needed {what}; install it: apt install {package}", name=module) from error
