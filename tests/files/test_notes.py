"""Notes on files: collected, logged once, in as few lines as they need, and kept in recordings."""

from soft_gripper.files.notes import LEFT_OUT, MENDED, Note, as_text, collect_notes, note, summarize


def test_notes_are_collected_once_and_logged_at_the_end(caplog) -> None:
    with collect_notes() as outer:
        with collect_notes() as inner:
            for joint in ("a", "b", "a"):
                note(LEFT_OUT, "arms/arm.urdf", f"joint '{joint}': dynamics.friction", 0.5, "Drake has none")
        note(MENDED, "arms/arm.urdf", "link 'x': inertia", "", "it was impossible")
        assert not caplog.messages
    assert [each.element for each in inner] == ["joint 'a': dynamics.friction", "joint 'b': dynamics.friction"]
    assert [each.outcome for each in outer] == [LEFT_OUT, LEFT_OUT, MENDED]
    assert caplog.messages == [
        "arm.urdf: left out joint 'a': dynamics.friction = 0.5, joint 'b': dynamics.friction = 0.5: Drake has none",
        "arm.urdf: mended link 'x': inertia: it was impossible",
    ]


def test_notes_are_short_and_stay_in_a_line() -> None:
    many = [Note(LEFT_OUT, "a.urdf", f"joint '{i}'", "", "why") for i in range(9)]
    assert summarize(many) == ["a.urdf: left out joint '0', joint '1', joint '2' and 6 more: why"]
    with collect_notes() as notes:
        note(MENDED, "a.urdf", "x\ny", "1\n" * 1000, "why")
    assert as_text(notes).count("\n") == 0
    assert len(as_text(notes)) < 200
