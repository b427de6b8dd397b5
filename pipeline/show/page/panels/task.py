"""The task: start, goal, visits and boxes to avoid, taken from the present pose."""

from typing import Any

from pipeline.config import Config
from pipeline.show.edits import box_around, task_pose, with_box, with_end, with_visit, without
from pipeline.show.page.app import App, Follow
from pipeline.show.words import task_entries


class TaskPanel:
    """Buttons that take the present pose for the task, and a list of what is in it."""

    def __init__(self, app: App) -> None:
        self._app = app
        gui = app.server.gui
        app.task_status = gui.add_html("")
        self._button("Start here", lambda: self._end("start"), "The pose and mode of the sliders become task.start")
        self._button("Goal here", lambda: self._end("goal"), "The pose and mode of the sliders become task.goal")
        self._button("Visit this pose", self._visit, "Added to task.visit, after the others")
        with gui.add_folder("A box to avoid, around the TCP", expand_by_default=False):
            self._size: Any = gui.add_vector3("size (m)", (0.2, 0.2, 0.2), min=(0.01, 0.01, 0.01), step=0.01)
            self._any_x: Any = gui.add_checkbox("any x", initial_value=False, hint="The box is as long as the machine")
            self._button("Avoid this box", self._avoid, "Added to task.avoid: the TCP does not enter it")
        with gui.add_folder("Go to an entry, or remove it", expand_by_default=False):
            self._entry: Any = gui.add_dropdown("entry", ("start", "goal"))
            self._button("Go there", self._go, "Move the machine to the pose of the entry")
            self._button("Remove", self._remove, "Remove the visit or the box")
        app.after_edit.append(self._follow)

    def _button(self, label: str, do: Follow, hint: str) -> None:
        async def clicked(_: Any) -> None:
            self._app.jobs.post_every(do)

        self._app.server.gui.add_button(label, hint=hint).on_click(clicked)

    def _end(self, end: str) -> None:
        self._app.edit(lambda config: with_end(config, end, self._app.session.posture.asked))

    def _visit(self) -> None:
        self._app.edit(lambda config: with_visit(config, self._app.session.posture.asked))

    def _avoid(self) -> None:
        box = box_around(self._app.session.posture.asked, self._size.value, self._any_x.value)
        self._app.edit(lambda config: with_box(config, box))

    def _go(self) -> None:
        self._app.jog(task_pose(self._app.session.config, self._entry.value))

    def _remove(self) -> None:
        def change(config: Config) -> Config:
            return without(config, self._entry.value)

        self._app.edit(change)

    def _follow(self) -> None:
        names = ("start", "goal", *(name for name, _ in task_entries(self._app.session.config)))
        if tuple(self._entry.options) != names:
            self._entry.options = names
