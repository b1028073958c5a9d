"""Cases: `case.toml`, read, changed and written."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, MutableMapping
from pathlib import Path
from typing import Any


class Case(MutableMapping[str, Any]):
    """The keys of a case, by their dotted names: `case["time.end_s"] = 0.1`. `fsi-driver keys` lists them.

    What a case does not say is taken from the defaults if it says `extends = "defaults"`.
    """

    def __init__(self, keys: dict[str, Any] | None = None) -> None:
        self.keys_by_table: dict[str, Any] = {}
        for key, value in (keys if keys is not None else {"extends": "defaults"}).items():
            self[key] = value

    @classmethod
    def read(cls, path: str | Path) -> Case:
        """Of a folder with a `case.toml`, or of that file."""
        path = Path(path)
        file = path / "case.toml" if path.is_dir() else path
        case = cls({})
        case.keys_by_table = tomllib.loads(file.read_text(encoding="utf-8"))
        return case

    def _table(self, name: str, make: bool = False) -> tuple[dict[str, Any], str]:
        *tables, last = name.split(".")
        table = self.keys_by_table
        for part in tables:
            if make:
                table = table.setdefault(part, {})
            else:
                table = table[part]
            if not isinstance(table, dict):
                raise TypeError(f"{name}: {part} is a value, not a table")
        return table, last

    def __getitem__(self, name: str) -> Any:
        table, last = self._table(name)
        return table[last]

    def __setitem__(self, name: str, value: Any) -> None:
        table, last = self._table(name, make=True)
        table[last] = value

    def __delitem__(self, name: str) -> None:
        table, last = self._table(name)
        del table[last]

    def __iter__(self) -> Iterator[str]:
        return _names(self.keys_by_table, "")

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        return f"Case({self.keys_by_table!r})"

    def text(self) -> str:
        """As TOML."""
        lines: list[str] = []
        _write(self.keys_by_table, "", lines)
        return "\n".join(lines) + "\n"

    def write(self, folder: str | Path) -> Path:
        """Writes `case.toml` in a folder, which is made if it is not there. Returns the folder."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "case.toml").write_text(self.text(), encoding="utf-8")
        return folder


def _names(table: dict[str, Any], before: str) -> Iterator[str]:
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _names(value, f"{before}{key}.")
        else:
            yield before + key


def _key(key: str) -> str:
    bare = key and all(c.isascii() and (c.isalnum() or c in "-_") for c in key)
    return key if bare else json.dumps(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if hasattr(value, "tolist"):  # numpy
        return _value(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"a case cannot hold {value!r}: numbers, texts, true and false, lists and tables of them")


def _write(table: dict[str, Any], name: str, lines: list[str]) -> None:
    def inner(value: Any) -> bool:
        return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)

    for key, value in table.items():
        if not isinstance(value, dict) and not inner(value):
            lines.append(f"{_key(key)} = {_value(value)}")
    for key, value in table.items():
        path = f"{name}.{_key(key)}" if name else _key(key)
        if isinstance(value, dict):
            lines += ["", f"[{path}]"]
            _write(value, path, lines)
        elif inner(value):
            for item in value:
                lines += ["", f"[[{path}]]"]
                _write(item, path, lines)
