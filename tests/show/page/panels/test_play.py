"""Motions that are played: those of the machine as it is."""

from tests.show.page.panels.conftest import Opened


def test_motions_go_with_their_machine(opened: Opened) -> None:
    """Motions of the run that was opened stay while its machine does, whatever else is changed."""
    assert len(opened.run.tracks) == 2
    session, task = opened.app.session, opened.app.session.config.task
    turned = task.model_copy(update={"start": task.goal, "goal": task.start})
    opened.app.edit(lambda config: config.model_copy(update={"task": turned}))
    assert session.config.task == turned
    assert opened.play.tracks == opened.run.tracks
    opened.lengthen_rail(2.6)
    assert opened.play.tracks == ()
