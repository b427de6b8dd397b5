"""Planning from here: the file is saved, a process of its own plans, and its result is drawn."""

import shlex
from pathlib import Path
from typing import Any

from pipeline.config.file import results_folder
from pipeline.route.checked_task import require_sound_task
from pipeline.show.page.app import App
from pipeline.show.page.panels.play import PlayPanel
from pipeline.show.planning.process import Planning
from pipeline.show.session import load_run
from pipeline.show.words import message_html, next_html
from pipeline.stage import Stage

_UP_TO = {
    "route": Stage.ROUTE,
    "path": Stage.REFINE,
    "certificate": Stage.CERTIFY,
    "trajectory (CSV)": Stage.RETIME,
    "figures and report": Stage.FIGURES,
}
_OTHER_MACHINE = (
    "The machine was changed while this was planned, so the motion is not played here. To see it, type "
    "gantry-tau show {}; to plan for the machine as it is now, press Plan again."
)
_STEPS = 8
"""Last messages that are shown."""


class PlanPanel:
    """Controls of planning, and the process while there is one."""

    def __init__(self, app: App, play: PlayPanel, folder: Path | None) -> None:
        self._app = app
        self._play = play
        self._folder = folder
        self._command = ""
        self._process: Planning | None = None
        self._lines: list[str] = []
        gui = app.server.gui
        self._name: Any = gui.add_text("file", str(app.session.file), hint="YAML; seen from the folder of the command")
        self._replace: Any = gui.add_checkbox("replace the file", initial_value=False, hint="If it is there already")
        self._save: Any = gui.add_button("Save", hint="Every key, with its meaning as a comment")
        self._last: Any = gui.add_dropdown(
            "plan up to", tuple(_UP_TO), hint="Finished stages are kept for the next time"
        )
        self._begin: Any = gui.add_button("Plan", hint="Saves the file unless it holds this task already, and plans it")
        self._stop: Any = gui.add_button("Stop", disabled=True)
        self._bar: Any = gui.add_progress_bar(0.0, visible=False)
        self._said: Any = gui.add_html("")

        async def save(_: Any) -> None:
            app.jobs.post_every(self._save_file)

        async def begin(_: Any) -> None:
            app.jobs.post_every(self.plan)

        async def stop(_: Any) -> None:
            app.jobs.post_every(self._ask_to_stop)

        app.after_edit.append(self._forget)
        self._save.on_click(save)
        self._begin.on_click(begin)
        self._stop.on_click(stop)

    def close(self) -> None:
        """End the process, if there is one."""
        if self._process is not None:
            self._process.close()

    def _forget(self) -> None:
        """Take back what was said of a task that has changed since."""
        if self._process is None:
            self._said.content = ""

    def _save_file(self) -> None:
        session = self._app.session
        session.save(Path(self._name.value).expanduser(), self._replace.value)
        file = shlex.quote(str(session.file))
        self._said.content = message_html(f"saved: {session.file}\nNext: plan it here, or type gantry-tau run {file}")

    def plan(self) -> None:
        """Save the configuration, and begin to plan it in a process."""
        session = self._app.session
        if self._process is not None:
            self._app.tell("a plan is being made already: stop it first")
            return
        # Before anything is written: a file that cannot be planned would stand in the way of the next one.
        require_sound_task(session.config, session.machine)
        session.require_file(Path(self._name.value).expanduser(), self._replace.value)
        self._folder = self._folder_of()
        self._command = self._command_of()
        self._lines = [f"{session.file} into {self._folder}"]
        self._begin.disabled, self._stop.disabled, self._bar.visible = True, False, True
        self._process = Planning(session.file, self._folder, _UP_TO[self._last.value], self._listen)

    def _folder_of(self) -> Path:
        """Give the folder that `gantry-tau run` would write to; that of the run, for the configuration in it."""
        file = self._app.session.file
        if self._folder is not None and file.parent == self._folder:
            return self._folder
        return results_folder(self._app.session.config.name)

    def _ask_to_stop(self) -> None:
        if self._process is not None:
            self._process.stop()

    def _listen(self, event: dict[str, Any]) -> None:
        """Hear what the process tells, in the thread that listens."""
        if "failure" in event:
            self._app.jobs.post_every(lambda: self._end(event["failure"]))
        else:
            self._app.jobs.post_every(lambda: self._show(event))

    def _show(self, event: dict[str, Any]) -> None:
        line = f"{event['stage']}: {event['message']}".replace("Ctrl-C", "Stop")
        if self._lines and self._lines[-1].split(":")[0] == str(event["stage"]):
            self._lines.pop()
        self._lines = [*self._lines, line][-_STEPS:]
        fraction = event.get("fraction")
        self._bar.value = 100.0 if fraction is None else 100.0 * fraction
        self._bar.animated = fraction is None
        self._said.content = message_html("\n".join(self._lines))

    def _end(self, failure: str) -> None:
        if self._process is not None:
            self._process.close()
        self._process = None
        self._begin.disabled, self._stop.disabled, self._bar.visible = False, True, False
        assert self._folder is not None
        steps = message_html("\n".join(self._lines))
        if failure:
            self._said.content = steps + message_html(failure, wrong=True)
            return
        run = load_run(self._folder)
        if run.results.config.machine != self._app.session.config.machine:
            self._said.content = steps + message_html(_OTHER_MACHINE.format(shlex.quote(str(self._folder))), wrong=True)
            return
        self._play.load(run)
        self._said.content = steps + next_html(self._command, self._folder, Stage.RETIME in run.done)

    def _command_of(self) -> str:
        """Give the command that plans the whole of this."""
        session = self._app.session
        out = "" if self._folder == results_folder(session.config.name) else f" --out {shlex.quote(str(self._folder))}"
        return f"gantry-tau run {shlex.quote(str(session.file))}{out}"
