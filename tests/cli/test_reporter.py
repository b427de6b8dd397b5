"""Progress on terminals and elsewhere."""

import re
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

import pipeline
from pipeline.cli.reporter import LiveReporter, PlainReporter, make_reporter
from pipeline.stage import STAGES, Stage

HIDE_CURSOR, SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"


class TestReporters:
    """Progress on terminals and elsewhere."""

    def test_choice(self) -> None:
        """Lines move on terminals only, and not if solvers write there too."""
        terminal = Console(file=StringIO(), force_terminal=True, legacy_windows=False, _environ={"TERM": "xterm"})
        dumb = Console(file=StringIO(), force_terminal=True, _environ={"TERM": "dumb"})
        assert isinstance(make_reporter(terminal, verbose=False), LiveReporter)
        assert isinstance(make_reporter(terminal, verbose=True), PlainReporter)
        assert isinstance(make_reporter(dumb, verbose=False), PlainReporter)
        assert isinstance(make_reporter(Console(file=StringIO()), verbose=False), PlainReporter)

    def test_plain_lines_are_rare(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """A message appears when the last one is five seconds old, with the fraction where it is known."""
        now = [0.0]
        monkeypatch.setattr("pipeline.cli.reporter.time.monotonic", lambda: now[0])
        file = StringIO()
        with PlainReporter(Console(file=file, width=20)) as reporter:
            progress = reporter.begin(Stage.ROUTE)
            for second in range(12):
                now[0] = float(second)
                progress(f"route: second {second} of a rather long story", second / 10 if second > 5 else None)
            reporter.end(Stage.ROUTE, "done", 11.04)
            reporter.end(Stage.REFINE, "unchanged", 3.0)
        assert file.getvalue().splitlines() == [
            "route: started",
            "route: second 5 of a rather long story",
            "route: second 10 of a rather long story (100%)",
            "route: done (11.0 s)",
            "refine: unchanged",
        ]

    def test_no_message_names_its_stage_twice(self) -> None:
        """A line begins with its stage, and leaves out `stage: ` in front of a message: nothing else names it."""
        doubled = re.compile(rf'progress\(\s*f?"(?:{"|".join(STAGES)}) |label = f?"(?:{"|".join(STAGES)}) ')
        sources = (Path(pipeline.__file__).parent).rglob("*.py")
        assert [str(path) for path in sources if doubled.search(path.read_text())] == []

    @pytest.mark.parametrize("colour", [True, False])
    def test_live_line(self, colour: bool) -> None:
        """The line shows stage, message and bar; nothing of it is left in the end but a line per stage."""
        file = StringIO()
        console = Console(
            file=file, force_terminal=True, width=100, no_color=not colour, _environ={"TERM": "xterm-256color"}
        )
        with LiveReporter(console) as reporter:
            progress = reporter.begin(Stage.ROUTE)
            progress("counting [moves]")
            progress("nearly there", 0.9)
            reporter._live.refresh()
            progress("no idea")
            reporter.end(Stage.ROUTE, "done", 1.25)
            reporter.end(Stage.REFINE, "unchanged", 1.0)
        text = file.getvalue()
        assert "nearly there" in text
        assert "route   done" in text
        assert "refine  unchanged" in text
        assert ("\x1b[32m" in text) is colour
        assert text.rindex(SHOW_CURSOR) > text.rindex(HIDE_CURSOR)

    def test_live_line_goes_away_after_errors(self) -> None:
        """The cursor comes back when a stage is interrupted."""
        file = StringIO()
        console = Console(file=file, force_terminal=True, _environ={"TERM": "xterm"})
        with pytest.raises(KeyboardInterrupt), LiveReporter(console) as reporter:
            reporter.begin(Stage.ROUTE)("working")
            raise KeyboardInterrupt
        assert file.getvalue().rindex(SHOW_CURSOR) > file.getvalue().rindex(HIDE_CURSOR)
