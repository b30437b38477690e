"""The report: what it says of each claim is what the claim says, in red where it fails; its table holds means."""

import base64
import re
from pathlib import Path

import pytest

from soft_gripper.evaluation.paper.claims import Claim
from soft_gripper.evaluation.paper.pose_table import PoseRow
from soft_gripper.evaluation.paper.report import write_report

HOLDS = Claim("paper", "one sensor is within 3 mm", True, "2.42 mm")
FAILS = Claim("ours", "four sensors are within 1 mm & less", False, "nan mm")
POSES = [
    PoseRow("free_bending", "finger", "arcs", "as simulated", n, pressure, 0.0, scale / n, 2 * scale / n + 3)
    for n in (1, 2, 3, 4)
    for pressure, scale in ((0.0, 0.0), (50.0, 1.0), (100.0, 5.0))
]


def page_of(folder: Path, claims: list[Claim]) -> str:
    """The report of one scenario, of which the pictures and the replay are mere names."""
    scene = folder / "free_bending"
    scene.mkdir()
    for name in ("scene.png", "replay.html", "../curve.svg"):
        (scene / name).write_text(name)
    write_report(folder, ["free_bending"], POSES, claims, {"curve": "A curve"})
    return (folder / "report.html").read_text()


def rows_of(page: str, kind: str = "<tr") -> list[list[str]]:
    """Cells of the rows of its tables, without what is inside the tags."""
    found = re.findall(rf"{kind}[^>]*>(.*?)</tr>", page, flags=re.DOTALL)
    return [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row, flags=re.DOTALL) for row in found]


def test_a_claim_is_reported_as_it_is(tmp_path: Path) -> None:
    page = page_of(tmp_path, [HOLDS, FAILS])
    assert rows_of(page, '<tr class="claim"') == [
        ["one sensor is within 3 mm", "paper", "holds", "2.42 mm"],
        ["four sensors are within 1 mm &amp; less", "ours", "fails", "nan mm"],
    ]
    assert page.count('<td class="text holds">holds</td>') == page.count('<td class="text fails">fails</td>') == 1


def test_what_fails_is_red(tmp_path: Path) -> None:
    page = page_of(tmp_path, [FAILS])
    color = re.search(r"\.fails \{ color: var\((--\w+)\)", page)
    assert color is not None
    value = re.search(rf"{color[1]}: #(..)(..)(..);", page)
    assert value is not None
    red, green, blue = (int(part, 16) for part in value.groups())
    assert red > 2 * max(green, blue)


@pytest.mark.parametrize(
    ("claims", "words"),
    [
        ([HOLDS, HOLDS], '<p class="holds">All 2 claims hold.</p>'),
        ([HOLDS, FAILS, FAILS], '<p class="fails">2 of 3 claims failed.</p>'),
    ],
)
def test_says_how_many_failed(claims: list[Claim], words: str, tmp_path: Path) -> None:
    assert words in page_of(tmp_path, claims)


def test_errors_are_means_over_the_steps(tmp_path: Path) -> None:
    """Of 0, 1 and 5 mm divided by the number of sensors; at the tip twice that and 3 mm more."""
    means = ["2.00", "1.00", "0.67", "0.50", "7.00", "5.00", "4.33", "4.00"]
    assert ["Free bending", *means] in rows_of(page_of(tmp_path, [HOLDS]))


def test_pictures_are_inside(tmp_path: Path) -> None:
    page = page_of(tmp_path, [HOLDS])
    for name in ("scene.png", "../curve.svg"):
        assert base64.b64encode(name.encode()).decode() in page
    assert not re.search(r'(src|href)="(?!data:)', page)
