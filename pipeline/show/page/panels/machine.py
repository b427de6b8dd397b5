"""The machine: rails, links and what limits them, as numbers to be changed."""

from typing import Any

from pipeline.config import Config
from pipeline.show.edits import machine_value, with_machine
from pipeline.show.page.app import App
from pipeline.show.words import note_html

_LINKS = (
    ("links.l1.length_m", "link 1 (m)"),
    ("links.l2a.length_m", "link 2a (m)"),
    ("links.l3a.length_m", "link 3a (m)"),
    ("links.l2b.stroke_m", "stroke 2b (m)"),
    ("links.l3b.stroke_m", "stroke 3b (m)"),
    ("clearance.link_link_m", "links apart (m)"),
    ("clearance.bodies_m", "bodies apart (m)"),
)
_RAIL = (("y_m", "y (m)"), ("z_m", "z (m)"), ("travel_m", "travel (m)"))
_REST = (
    "All other keys (platform, masses, forces, the grid of the route) are in the file: save it, edit it, and open it "
    "here again."
)


class MachinePanel:
    """Numbers of rails, links and clearance; every change is drawn at once, or refused."""

    def __init__(self, app: App) -> None:
        self._app = app
        rails = [(f"rails.{k}.{key}", f"rail {k + 1}: {name}") for k in range(3) for key, name in _RAIL]
        self._fields = {key: self._add(key, name) for key, name in (*rails, *_LINKS)}
        app.server.gui.add_html(note_html(_REST))
        app.after_edit.append(self._follow)

    def _add(self, key: str, name: str) -> Any:
        gui, value = self._app.server.gui, machine_value(self._app.session.config, key)
        field: Any = (
            gui.add_vector2(name, value, step=0.01)
            if isinstance(value, tuple)
            else gui.add_number(name, _shown(value), step=0.01)
        )
        field.visible = _applies(self._app.session.config, key)

        async def changed(event: Any) -> None:
            if event.client is not None:
                self._app.jobs.post(key, lambda: self._change(key))

        field.on_update(changed)
        return field

    def _change(self, key: str) -> None:
        value = self._fields[key].value

        def change(config: Config) -> Config:
            return with_machine(config, {key: list(value) if isinstance(value, tuple) else value})

        try:
            self._app.edit(change)
        finally:
            self._follow()

    def _follow(self) -> None:
        for key, field in self._fields.items():
            field.value = _shown(machine_value(self._app.session.config, key))
            field.visible = _applies(self._app.session.config, key)


def _applies(config: Config, key: str) -> bool:
    """Tell whether a machine has such a number: links have no distance of axes where they have surfaces."""
    if key == "clearance.bodies_m":
        return bool(config.machine.bodies) or config.machine.link_bodies is not None
    return machine_value(config, key) is not None


def _shown(value: Any) -> Any:
    """Give the value of a field; zero where there is none, and the field is hidden."""
    return 0.0 if value is None else value
