"""README's measured tables as reStructuredText, so that the site and README never tell different figures."""

import re
from pathlib import Path


def prepare(readme: Path, target: Path) -> None:
    """Write the tables of README's "How accurate, how fast" to `target`."""
    section = readme.read_text(encoding="utf-8").split("\n## How accurate, how fast\n")[1].split("\n## ")[0]
    target.parent.mkdir(parents=True, exist_ok=True)
    pieces = [_piece(paragraph) for paragraph in section.strip().split("\n\n")]
    target.write_text("\n\n".join(pieces) + "\n", encoding="utf-8")


def _piece(paragraph: str) -> str:
    text = re.sub(r"`([^`]+)`", r"``\1``", paragraph)
    if not text.startswith("|"):
        return text
    rows = [[cell.strip() for cell in line.strip("|").split(" |")] for line in text.splitlines()]
    rows = [[cell.strip("| ") for cell in row] for number, row in enumerate(rows) if number != 1]
    lines = [".. list-table::", "   :header-rows: 1", ""]
    for row in rows:
        lines += [f"   {'* -' if number == 0 else '  -'} {cell}".rstrip() for number, cell in enumerate(row)]
    return "\n".join(lines)
