"""Steps, without Drake: for one sample, for several at once, and over a recording."""

import subprocess
import sys

import numpy as np
import pytest

from soft_gripper.steps import TIME, Memory, Step, Steps, constant, row_by_row, sampled

SAMPLES = 5
X = np.arange(2.0 * SAMPLES).reshape(SAMPLES, 2) ** 2
OFFSET = np.array([1.0, -1.0])


def running(before, x, offset):
    return before + x + offset


def totals(x, offset):
    return np.cumsum(x + offset, axis=0)


def joined(*values):
    return np.concatenate(values, axis=-1)


def rename(name):
    return name if name == TIME else f"block/{name}"


def graph():
    """The sum of all x and offsets so far, and the sample before of x and of the time."""
    memory = Memory(np.zeros(2), lambda total: total, ("total",), at_first=True)
    steps = {
        "x": Step(),
        "offset": constant(OFFSET),
        "total": Step(running, ("x", "offset"), memory, totals, ("x", "offset")),
        "before": sampled("x", np.full(2, 7.0), at_initialization=False),
        "now": sampled(TIME, np.zeros(1)),
    }
    return Steps(steps, {"all": (joined, ("total", "before", "now", "total"))})


def sample_by_sample(steps, inputs, x="x"):
    """The output "all" at every sample; memories are kept together, once all are known."""
    memories = {name: step.memory for name, step in steps.items() if step.memory is not None}
    remembered, found = {name: memory.begin for name, memory in memories.items()}, []
    for number, value in enumerate(inputs):
        known = {x: value, TIME: np.full((*value.shape[:-1], 1), 0.5 * number)}
        found.append(np.array(steps.output("all", known, remembered)))
        remembered = {
            name: memory.keep(*[steps.value(source, known, remembered) for source in memory.sources])
            for name, memory in memories.items()
        }
    return np.array(found)


EXPECTED = np.hstack(
    [
        np.cumsum(X + OFFSET, axis=0),
        np.vstack([[7.0, 7.0], X[:-1]]),
        0.5 * np.array([[0.0], [0.0], [1.0], [2.0], [3.0]]),
        np.cumsum(X + OFFSET, axis=0),
    ]
)


@pytest.mark.parametrize("many", [Steps.stacked, lambda steps, count: row_by_row([steps] * count)])
def test_several_at_once(many):
    """Each of three does what it does alone, also where functions take one sample only."""
    factors = np.array([1.0, 2.0, -1.0])
    found = sample_by_sample(many(graph(), 3), factors[:, None] * X[:, None])
    for i, factor in enumerate(factors):
        np.testing.assert_array_equal(found[:, i], sample_by_sample(graph(), factor * X))


def test_rows_have_functions_constants_and_beginnings_of_their_own():
    graphs = []
    for factor in (1.0, 3.0):
        memory = Memory(np.full(2, factor), lambda total, factor=factor: factor * total, ("total",), at_first=True)
        steps = {
            "x": Step(),
            "offset": constant(factor * OFFSET),
            "total": Step(lambda before, x, offset: before + x + offset, ("x", "offset"), memory),
        }
        graphs.append(Steps(steps, {"all": (lambda total, factor=factor: factor + total, ("total",))}))
    found = sample_by_sample(row_by_row(graphs), np.stack([X, X], axis=1))
    for i, graph in enumerate(graphs):
        np.testing.assert_array_equal(found[:, i], sample_by_sample(graph, X))


def test_which_outputs_change_with_the_time_between_samples():
    steps = Steps(
        {"x": Step(), "now": sampled(TIME, np.zeros(1)), "late": Step(joined, ("x", TIME))},
        {"x": (joined, ["x"]), "now": (joined, ["now"]), "late": (joined, ["late"])},
    )
    assert [name for name in steps.outputs if steps.takes_time(name)] == ["late"]


def test_a_recording_is_all_samples():
    known = {"x": X, TIME: 0.5 * np.arange(SAMPLES)[:, None]}
    np.testing.assert_array_equal(graph().recorded.output("all", known), EXPECTED)
    assert set(known) == {"x", TIME, "total"}, "only a step with several readers is added"


def test_steps_of_other_names_are_the_same_steps():
    steps = graph()
    renamed = {rename(name): step.renamed(rename) for name, step in steps.items()}
    function, sources = steps.outputs["all"]
    found = Steps(renamed, {"all": (function, [*map(rename, sources)])})
    np.testing.assert_array_equal(sample_by_sample(found, X, "block/x"), EXPECTED)
    assert found.leaves("all") == ["block/x"]


def test_what_follows_over_a_recording():
    steps = graph()
    assert steps.leaves("all") == ["x"]
    assert steps.follows("all", remembers=True)
    assert not steps.follows("all", remembers=False)
    steps["before"] = sampled("x", np.zeros(2), at_first=False)
    assert not steps.follows("all", remembers=True)


def test_steps_know_no_drake():
    program = (
        "import sys, soft_gripper.steps; sys.exit(any(name.partition('.')[0] == 'pydrake' for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
