"""A page for each shipped scenario and one of all, from their files, diagrams, and what store_scenarios.py has kept."""

import csv
import re
from collections.abc import Iterator

from links import ROOT
from port_tables import signals_table
from tables import prose, table

from soft_gripper.scenario.shipped import descriptions, scenario_path

STORED = ROOT / "docs" / "scenarios"
_BREAK = "\u200b"  # where a line may break
_ALL = """\
# Scenarios

Every scenario that is shipped, with its command, its signals, and the criteria by which a run of it is a success. A
scenario of your own begins as a copy of one of these files; its `success` lists criteria such as `grasp is held` or
`slid_mm at most 1`, of the measures of a [sweep](sweeps.md), and `run` compares them with what it measures.

{cards}

```{{toctree}}
:hidden:

{names}
```
"""
_CARD = """\
:::{{grid-item-card}} {title}
:img-top: scenarios/{name}.webp
:link: scenarios/{name}
:link-type: doc

{description}
:::
"""
_PAGE = """\
# {name}

{description}.

![{description}]({name}.webp)

    soft-gripper run {name}

{comment} The file is [{path}](../files/{path}.md).

## Criteria of success

{criteria}

## Signals

`recording["NAME"]` of its recording; of several fingers, those of the first.

:::{{dropdown}} {count} signals

{signals}
:::
"""


def scenario_pages() -> Iterator[tuple[str, str]]:
    """Markdown, by place on the site."""
    known = descriptions()
    cards = "".join(
        _CARD.format(name=name, title=name.replace("_", f"_{_BREAK}"), description=text) for name, text in known.items()
    )
    grid = f"::::{{grid}} 1 2 2 3\n:gutter: 3\n\n{cards}::::"
    yield "scenarios.md", _ALL.format(cards=grid, names="\n".join(f"scenarios/{name}" for name in known))
    for name, description in known.items():
        yield f"scenarios/{name}.md", _page(name, description)


def stored_criteria(name: str) -> list[dict[str, str]]:
    """The rows that store_scenarios.py kept of a scenario: criterion, whether it was met, and what was measured."""
    with (STORED / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _page(name: str, description: str) -> str:
    path = scenario_path(name)
    lines = re.match(r"(#.*\n)*", path.read_text(encoding="utf-8"))
    comment = " ".join(line.removeprefix("#").strip() for line in lines[0].splitlines()) if lines else ""
    rows = [(prose(row["criterion"]), prose(row["measured"] or "met")) for row in stored_criteria(name)]
    signals = signals_table(name)
    return _PAGE.format(
        name=name,
        description=description,
        comment=prose(comment),
        path=path.resolve().relative_to(ROOT).as_posix(),
        criteria=table(("criterion", "measured"), rows),
        count=len(signals.splitlines()) - 2,
        signals=signals,
    )
