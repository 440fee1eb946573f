"""Measured figures: one file of docs/data each, with what made them, and the tables of the pages that are drawn from them.

A file docs/data/NAME.json holds
  about     what was measured, under which conditions
  version, commit, machine, command      what made the figures; text
  tables    by name: columns (headings), rows (lists of texts), and "left": true where no column is aligned to the right
"""
import json
import os
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "docs/data"
REQUIRED = ("about", "version", "commit", "machine", "command")


def read(path):
    """The content of a data file. ValueError names what is wrong with it."""
    data = json.loads(path.read_text())
    for key in REQUIRED:
        if not isinstance(data.get(key), str) or not data[key]:
            raise ValueError(f"{path}: {key}: found {data.get(key)!r}, expected text")
    if not data.get("tables"):
        raise ValueError(f"{path}: found no tables, expected one or more")
    for name, table in data["tables"].items():
        for row in table["rows"]:
            if len(row) != len(table["columns"]):
                raise ValueError(f"{path}: {name}: found {len(row)} fields in {row}, expected {len(table['columns'])}")
    return data


def write(name, data):
    """Writes docs/data/NAME.json, one row of a table a line."""
    tables = []
    for key, table in data["tables"].items():
        rows = ",\n".join("        " + json.dumps(row, ensure_ascii=False) for row in table["rows"])
        left = '\n      "left": true,' if table.get("left") else ""
        columns = json.dumps(table["columns"], ensure_ascii=False)
        tables.append(f'    {json.dumps(key)}: {{{left}\n      "columns": {columns},\n      "rows": [\n{rows}\n      ]\n    }}')
    head = ",\n".join(f"  {json.dumps(k)}: {json.dumps(data[k], ensure_ascii=False)}" for k in REQUIRED)
    DATA.mkdir(exist_ok=True)
    path = DATA / f"{name}.json"
    path.write_text(f'{{\n{head},\n  "tables": {{\n' + ",\n".join(tables) + "\n  }\n}\n")
    read(path)


def draw(table):
    columns = table["columns"]
    rule = ["---"] * len(columns) if table.get("left") else ["---"] + ["---:"] * (len(columns) - 1)
    return "\n".join("|" + "|".join(row) + "|" for row in [columns, rule, *table["rows"]])


def block(page, what):
    """What stands below `<!-- figures: WHAT -->` in a page: all tables of a data file, or with NAME.TABLE one of them."""
    name, _, only = what.partition(".")
    path = DATA / f"{name}.json"
    if not path.exists():
        raise ValueError(f"{page}: found figures: {what}, expected a file {path.relative_to(ROOT)}")
    tables = read(path)["tables"]
    if only and only not in tables:
        raise ValueError(f"{page}: found figures: {what}, expected one of {', '.join(tables)}")
    drawn = [draw(tables[only])] if only else [draw(table) for table in tables.values()]
    link = os.path.relpath(path, page.parent)
    return "\n\n".join([*drawn, f"[Version, machine, command]({link})"])
