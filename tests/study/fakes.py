"""Workers that answer at once, in place of Dask's, and studies of the tiny configuration."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from pipeline.config import Config
from pipeline.config.file import dump_config
from pipeline.study.cases import Case, Cases, build_cases
from pipeline.study.config import load_study
from pipeline.study.pool import Pool
from pipeline.study.rows import Ending, Row

Answer = Callable[[dict[str, Any]], dict[str, Any]]


@dataclass(eq=False)
class FakeFuture:
    """A future that has ended."""

    status: str
    answer: Any

    def add_done_callback(self, callback: Callable[[Any], None]) -> None:
        """Call back immediately."""
        callback(self)

    def result(self) -> Any:
        """Give the answer."""
        return self.answer

    def exception(self) -> BaseException:
        """Give the answer of a future that failed."""
        assert isinstance(self.answer, BaseException)
        return self.answer


@dataclass
class FakeClient:
    """A client whose workers answer as they are told."""

    answer: Answer
    memory_gb: float = 64.0
    status: str = "running"
    programs: dict[str, str] = field(default_factory=dict)
    asked: list[str] = field(default_factory=list)

    def scheduler_info(self, n_workers: int) -> dict[str, Any]:
        """Describe two workers."""
        worker = {"nthreads": 1, "resources": {"memory_gb": self.memory_gb}}
        return {"workers": {"a": worker, "b": worker}}

    def run(self, _function: Any) -> dict[str, str]:
        """Name the programs of the workers."""
        return self.programs

    def submit(self, _function: Any, request: dict[str, Any], **_options: Any) -> FakeFuture:
        """Answer a request."""
        self.asked.append(request["key"])
        answer = self.answer(request)
        if "lost" in answer:
            return FakeFuture("lost", None)
        return FakeFuture("error", answer["raised"]) if "raised" in answer else FakeFuture("finished", answer)

    def pool(self) -> Pool:
        """Give the workers as a study sees them."""
        return Pool(self, "tcp://nowhere:1")  # type: ignore[arg-type]


def done(request: dict[str, Any]) -> dict[str, Any]:
    """Answer with a row whose figures follow from the request."""
    tilt = request["data"]["task"]["tilt_max_deg"]
    figures = {
        "path.kappa_max": 30.0,
        "path.kappa_integral": 1000.0 / tilt,
        "trajectory.duration_s": tilt,
        "path.status": "converged",
    }
    row = Row(request["key"], Ending.DONE.value, figures=figures, time_limit_s=request["time_limit_s"])
    return {"row": row.data()}


def done_row(case: Case) -> Row:
    """Make the row of a case as such workers do."""
    return Row.read(done({"key": case.key, "data": case.data, "time_limit_s": 1.0})["row"])


def study_file(folder: Path, config: Config, **keys: Any) -> Path:
    """Write a study of a configuration; by default of three tilt limits."""
    (folder / "base.yaml").write_text(dump_config(config))
    parameters = [{"key": "task.tilt_max_deg", "values": [10, 20, 30]}]
    whole = {"base": "base.yaml", "to": "route", **({"parameters": parameters} if "points" not in keys else {}), **keys}
    file = folder / "tilts.yaml"
    file.write_text(yaml.safe_dump(whole))
    return file


def cases_of(folder: Path, config: Config, program: str = "1", **keys: Any) -> Cases:
    """Make the cases of such a study."""
    file = study_file(folder, config, **keys)
    return build_cases(load_study(file), file, program)
